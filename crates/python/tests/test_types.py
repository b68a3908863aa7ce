"""The types of the package, as mypy sees them."""

import subprocess
import sys

USE = """
import numpy as np
import wgdenoise

color = np.zeros((4, 4, 3), np.float32)
reveal_type(wgdenoise.denoise(color, color, quality="fast"))
denoiser = wgdenoise.Denoiser(device=0)
reveal_type(denoiser.denoise(color)[0, 0])
reveal_type(denoiser.denoise(color, layers={"sun": color}).layers)
reveal_type(wgdenoise.compare(color, color).psnr)
wgdenoise.denoise_exr("a.exr", "b.exr", force=True)
denoiser.denoise(color, color, color, color)
wgdenoise.Denoiser(tile="wide")
"""


def run(*words, cwd):
    command = [sys.executable, "-m", *words]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=600).stdout


def test_a_result_is_an_array_or_has_layers_and_wrong_arguments_are_found(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    found = run("mypy", "--strict", "use.py", cwd=tmp_path)
    revealed = [line.split('"')[1] for line in found.splitlines() if "Revealed type" in line]
    assert "ndarray" in revealed[0] and "Denoised" not in revealed[0], found
    assert "Denoised" not in revealed[1], found
    assert "dict[" in revealed[2] and revealed[3].endswith("float"), found
    errors = [line for line in found.splitlines() if "error:" in line]
    assert len(errors) == 2 and '"tile"' in errors[1] and "denoise" in errors[0], found


def test_the_package_is_typed_and_the_stub_is_that_of_the_compiled_module(tmp_path):
    found = run("mypy", "--strict", "-p", "wgdenoise", cwd=tmp_path)
    assert "Success" in found, found
    words = ["mypy.stubtest", "--ignore-disjoint-bases", "wgdenoise._wgdenoise"]
    found = run(*words, cwd=tmp_path)
    assert "Success" in found, found
