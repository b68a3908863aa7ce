"""Files: bit-identical to the command line, with its errors, and the command in the wheel."""

import logging
import os
import signal
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest
from conftest import REPOSITORY, WEIGHTS, image

import wgdenoise

SAMPLE = REPOSITORY / "samples/still_life_8spp.exr"
DATA = REPOSITORY / "crates/cli/tests/data"


def command(*words):
    run = [sys.executable, "-m", "wgdenoise", *map(str, words)]
    return subprocess.run(run, capture_output=True, text=True, timeout=600)


def channels(path):
    """Return the arrays of an EXR file by part and channel."""
    with OpenEXR.File(str(path)) as file:
        return [
            {name: channel.pixels.copy() for name, channel in part.channels.items()}
            for part in file.parts
        ]


def write(path, color):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": color}).write(str(path))


def test_an_array_gets_the_bits_of_the_command_line(tmp_path, denoiser, noisy):
    write(tmp_path / "noisy.exr", noisy)
    run = command("--quality=fast", tmp_path / "noisy.exr", tmp_path / "clean.exr")
    assert run.returncode == 0, run.stderr
    np.testing.assert_array_equal(channels(tmp_path / "clean.exr")[0]["RGB"], denoiser.denoise(noisy))


def test_a_file_gets_the_bits_of_the_command_line(tmp_path):
    source = DATA / "light_groups.exr"
    wgdenoise.denoise_exr(source, tmp_path / "python.exr", quality="fast", layers="auto")
    run = command("--quality", "fast", "--layers", "auto", source, tmp_path / "program.exr")
    assert run.returncode == 0, run.stderr
    python, program = [(tmp_path / name).read_bytes() for name in ("python.exr", "program.exr")]
    assert python == program and python != source.read_bytes()


def test_messages_go_to_the_logger_and_progress_to_the_callback(tmp_path, caplog):
    steps = []
    with caplog.at_level(logging.INFO, "wgdenoise"):
        wgdenoise.denoise_exr(
            DATA / "plain_rgb.exr",
            tmp_path / "clean.exr",
            weights=WEIGHTS,
            progress=lambda *step: steps.append(step),
        )
    assert caplog.messages[-1].startswith(f"wrote {tmp_path / 'clean.exr'}")
    assert steps[0] == (0, 1000) and steps[-1] == (1000, 1000)


def test_one_of_several_images_that_fails_is_logged_as_an_error(tmp_path, caplog):
    (tmp_path / "broken.exr").write_text("no image")
    sources = [tmp_path / "broken.exr", DATA / "plain_rgb.exr"]
    with pytest.raises(wgdenoise.FileError, match="1 of 2 images failed"):
        wgdenoise.denoise_exr(sources, tmp_path / "out/", parents=True, weights=WEIGHTS)
    errors = [record for record in caplog.records if record.levelno == logging.ERROR]
    assert len(errors) == 1 and "broken.exr" in errors[0].getMessage()
    assert (tmp_path / "out/plain_rgb.exr").is_file()


@pytest.mark.parametrize(
    ("source", "options", "error", "sentence"),
    [
        ("missing.exr", {}, wgdenoise.FileError, "missing.exr"),
        (DATA / "plain_rgb.exr", {"haste": True}, wgdenoise.UsageError, "unexpected argument '--haste'"),
        (DATA / "plain_rgb.exr", {"quality": "best"}, wgdenoise.UsageError, "invalid value 'best'"),
        (DATA / "plain_rgb.exr", {"color": "none"}, wgdenoise.FileError, "none"),
        (DATA / "plain_rgb.exr", {"adapter": "none"}, wgdenoise.AdapterError, "`none` matches none"),
        ([], {}, wgdenoise.UsageError, "src is empty"),
    ],
)
def test_failures_have_the_sentences_of_the_program(tmp_path, source, options, error, sentence):
    with pytest.raises(error) as caught:
        wgdenoise.denoise_exr(source, tmp_path / "clean.exr", **options)
    assert sentence in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_exists_is_kept_unless_forced(tmp_path):
    output = tmp_path / "clean.exr"
    output.write_text("mine")
    with pytest.raises(wgdenoise.FileError, match="exists"):
        wgdenoise.denoise_exr(DATA / "plain_rgb.exr", output, weights=WEIGHTS)
    wgdenoise.denoise_exr(DATA / "plain_rgb.exr", output, weights=WEIGHTS, force=True, verify=False)
    assert output.read_bytes() != b"mine"


def test_what_the_callback_raises_leaves_no_file(tmp_path):
    def fail(done, total):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        wgdenoise.denoise_exr(
            DATA / "plain_rgb.exr", tmp_path / "clean.exr", weights=WEIGHTS, progress=fail
        )
    assert list(tmp_path.iterdir()) == []


def test_the_command_has_its_output_and_exit_codes():
    assert "Removes Monte Carlo noise" in command("--help").stdout
    assert command("--version").stdout == f"wgdenoise {wgdenoise.__version__}\n"
    assert command("devices").returncode == 0
    refused = command("missing.exr", "out.exr")
    assert refused.returncode == 1 and "missing.exr" in refused.stderr
    assert command("--quality=best", "a.exr", "b.exr").returncode == 2


def test_ctrl_c_ends_the_command_with_its_exit_code_and_no_file(tmp_path):
    write(tmp_path / "noisy.exr", image(1024, 1024))
    words = ["--quality=high", "-v", str(tmp_path / "noisy.exr"), str(tmp_path / "clean.exr")]
    run = [sys.executable, "-m", "wgdenoise", *words]
    process = subprocess.Popen(run, stderr=subprocess.PIPE, text=True)
    for line in process.stderr:
        if "GPU memory" in line:
            break
    process.send_signal(signal.SIGINT)
    _, rest = process.communicate(timeout=60)
    assert process.returncode == 130 and "stopped before an image was written" in rest
    assert os.listdir(tmp_path) == ["noisy.exr"]


def test_ctrl_c_ends_a_command_that_leaves_signals_alone(tmp_path):
    pipe = tmp_path / "noisy.exr"
    os.mkfifo(pipe)
    process = subprocess.Popen([sys.executable, "-m", "wgdenoise", "info", str(pipe)])
    # Blocks until the command reads.
    with pipe.open("wb"):
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == -signal.SIGINT
