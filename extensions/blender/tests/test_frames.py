# SPDX-License-Identifier: MIT OR Apache-2.0
"""Frames on disk: a folder of frames, and frames that a render has just written."""

import bpy
import pytest
from conftest import denoised_by_command_line, multilayer
from test_render import refused


@pytest.fixture
def frames(scene, tmp_path):
    """Two frames in a folder."""
    multilayer(scene)
    scene.render.filepath = str(tmp_path / "frames" / "frame_")
    scene.frame_start, scene.frame_end = 1, 2
    bpy.ops.render.render(animation=True)
    scene.wgdenoise.folder = str(tmp_path / "frames")
    return tmp_path / "frames"


def expected(frames, tmp_path):
    """The bytes that the program writes for the frames, by file name."""
    return {path.name: denoised_by_command_line(path, tmp_path / path.name) for path in frames.glob("*.exr")}


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.exr")}


def test_a_folder_is_denoised_beside(scene, frames, tmp_path):
    clean, noisy = expected(frames, tmp_path), contents(frames)
    assert bpy.ops.wgdenoise.folder() == {"FINISHED"}
    assert len(clean) == 2 and contents(frames / "denoised") == clean and contents(frames) == noisy


def test_a_folder_is_denoised_again(scene, frames, tmp_path):
    bpy.ops.wgdenoise.folder()
    scene.cycles.seed = 7
    bpy.ops.render.render(animation=True)
    bpy.ops.wgdenoise.folder()
    assert contents(frames / "denoised") == expected(frames, tmp_path)


def test_a_folder_is_denoised_into_its_files(scene, frames, tmp_path):
    clean = expected(frames, tmp_path)
    scene.wgdenoise.files = "replace"
    bpy.ops.wgdenoise.folder()
    assert contents(frames) == clean and not (frames / "denoised").exists()


def test_a_broken_frame_is_named_and_the_others_are_denoised(scene, frames, queue):
    (frames / "frame_0001.exr").write_bytes(b"no image")
    assert "frame_0001.exr" in refused(bpy.ops.wgdenoise.folder, queue)
    assert [path.name for path in (frames / "denoised").iterdir()] == ["frame_0002.exr"]


def test_a_canceled_folder_changes_no_file(part, scene, frames, queue):
    scene.wgdenoise.files = "replace"
    noisy = contents(frames)
    job = part("jobs").of_folder(scene)
    job.cancel()
    queue.run(job)
    assert contents(frames) == noisy and queue.message == "Canceled"


@pytest.mark.parametrize(
    ("folder", "sentence"),
    [("", "No folder is set"), ("//frames", "save it first"), ("/nowhere", "has no OpenEXR files")],
)
def test_a_folder_that_cannot_be_denoised_is_one_sentence(scene, queue, folder, sentence):
    scene.wgdenoise.folder = folder
    assert sentence in refused(bpy.ops.wgdenoise.folder, queue)


def test_a_folder_relative_to_a_saved_file_is_found(scene, frames, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    scene.wgdenoise.folder = "//frames"
    bpy.ops.wgdenoise.folder()
    assert len(contents(frames / "denoised")) == 2


def test_every_render_is_denoised_if_automatic(scene):
    bpy.ops.render.render()
    assert "Scene denoised" not in bpy.data.images
    scene.wgdenoise.automatic = True
    bpy.ops.render.render()
    assert bpy.data.images["Scene denoised"].packed_file.size > 1000


def test_every_frame_is_denoised_if_automatic(scene, frames, tmp_path):
    scene.wgdenoise.automatic = True
    bpy.ops.render.render(animation=True)
    assert len(contents(frames)) == 2
    assert contents(frames / "denoised") == expected(frames, tmp_path)
    assert "Scene denoised" not in bpy.data.images


def test_a_still_that_is_written_is_denoised_and_not_the_frame_beside_it(scene, frames, tmp_path):
    scene.wgdenoise.automatic = True
    bpy.ops.render.render(write_still=True)
    assert list(contents(frames / "denoised")) == ["frame_.exr"]


def test_frames_in_other_formats_are_refused_in_one_sentence(scene, queue, tmp_path):
    scene.wgdenoise.automatic = True
    bpy.ops.render.render(write_still=True)
    assert (tmp_path / "frame_.png").is_file() and not (tmp_path / "denoised").exists()
    assert queue.failed and "set the output to OpenEXR MultiLayer" in queue.message
