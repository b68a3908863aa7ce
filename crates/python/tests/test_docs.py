"""Runs the examples of docs/python.md, except Blender's, which needs Blender."""

import os
import re
import shutil

import mitsuba as mi
import numpy as np
import OpenEXR
import pytest
from conftest import REPOSITORY, image

PAGE = (REPOSITORY / "docs/python.md").read_text()
EXAMPLES = re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)


def example(word):
    (found,) = [code for code in EXAMPLES if word in code]
    return found


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.makedirs("frames")
    shutil.copytree(REPOSITORY / "samples", "samples")
    return tmp_path


def test_every_example_is_known_here():
    words = ["default_rng", "frames", "import mitsuba", "import bpy", "np.dstack", "logging"]
    assert [example(word) for word in words] == EXAMPLES


def test_the_first_example_prints_what_the_page_shows(folder, capsys):
    exec(example("default_rng"), {})
    printed = capsys.readouterr().out.split()
    shown = re.search(r"prints `(.*?)`", PAGE).group(1).split()
    assert printed[:-1] == shown[:-1]
    # About twenty layers each round to 16 bits, by at most 2⁻¹¹, and devices sum in different orders.
    assert float(printed[-1]) == pytest.approx(float(shown[-1]), rel=20 * 2**-11)


def test_frames_come_out_denoised_under_their_names(folder):
    noisy = image(64, 64)
    for name in ("a.exr", "b.exr"):
        OpenEXR.File({}, {"RGB": noisy}).write(f"frames/{name}")
    exec(example("frames"), {})
    for name in ("a.exr", "b.exr"):
        assert OpenEXR.File(f"clean/{name}").channels()["RGB"].pixels.std() < 0.5 * noisy.std()


def test_mitsuba_writes_a_denoised_image(folder):
    exec(example("import mitsuba"), {})
    assert np.array(mi.Bitmap("clean.exr")).shape == (256, 256, 3)


def test_openexr_and_the_files_of_the_command_line_agree(folder):
    exec(example("np.dstack"), {})
    found = OpenEXR.File("clean.exr").channels()["RGBA"].pixels
    os.remove("clean.exr")
    exec(example("logging").replace('quality="fast", alpha="keep"', ""), {})
    expected = OpenEXR.File("clean.exr").parts[0].channels["ViewLayer.Combined"].pixels
    # The file stores 16 bits.
    np.testing.assert_array_equal(found.astype(np.float16), expected)
