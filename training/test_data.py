"""Tests of the data: scenes, views, their split, and crops. Run `pytest` in this folder."""

import json
from types import SimpleNamespace

import numpy as np
import OpenEXR
import pytest
import torch

from augment import Crops, noisier
from import_exr import FEATURES, main as import_exr
from render import kinds, meshes
from render.job import sample_counts, seed_sequence
from render.scene import Mesh
from render_animations import scenes_of
from transfer import inverse, transfer
from views import part, read_view
from write_view import write_view


@pytest.fixture
def random():
    return torch.Generator().manual_seed(1)


def test_a_view_is_read_as_it_was_written(tmp_path, random):
    image = torch.rand(9, 24, 32, generator=random).numpy()
    image[:3] *= 50
    write_view(tmp_path / "room000003_v1.npz", image, [(4, image * 0.5)], kind="room", ref_relerr=0.1)
    view = read_view(tmp_path / "room000003_v1.npz")
    assert (view["scene"], view["kind"], view["relerr"], view["noisy"][0][0]) == ("room000003", "room", 0.1, 4)
    np.testing.assert_allclose(view["ref"][:3], image[:3], rtol=2**-7)
    np.testing.assert_allclose(view["ref"][3:], image[3:], atol=1 / 127)
    np.testing.assert_allclose(view["noisy"][0][1][:3], image[:3] * 0.5, rtol=2**-6)


@pytest.fixture
def renders(tmp_path, random, monkeypatch):
    """Two files with color in layer `C` of one part and features in another, and a program that reports them."""
    def layer(part, name, letters):
        return dict(name=name, part=part, channels=[dict(name=letter) for letter in letters])

    def write(name, planes):
        header = dict(compression=OpenEXR.ZIP_COMPRESSION, type=OpenEXR.scanlineimage)
        names = ["R", "G", "B"], ["albedo.R", "albedo.G", "albedo.B", "N.x", "N.y", "N.z"]
        parts = [OpenEXR.Part(dict(header), dict(zip(own, planes[3 * i:])), f"part{i}") for i, own in enumerate(names)]
        OpenEXR.File(parts).write(str(tmp_path / name))

    told = dict(color="C", albedo="albedo", normal="N",
                layers=[layer(0, "C", "BGR"), layer(1, "albedo", "BGR"), layer(1, "N", "xyz")])
    images = torch.rand(2, 9, 130, 140, generator=random).numpy()
    for name, image in zip(("ref.exr", "noisy.exr"), images):
        write(name, image)

    def run(*words):
        program = tmp_path / "program"
        program.write_text(f"#!/bin/sh\ncat <<'EOF'\n{json.dumps(told)}\nEOF\n")
        program.chmod(0o755)
        words = [str(tmp_path / word) if word.endswith((".npz", ".exr")) and "=" not in word else word for word in words]
        monkeypatch.setattr("sys.argv", ["import_exr.py", *words, f"4={tmp_path / 'noisy.exr'}", "--program", str(program)])
        import_exr()

    return SimpleNamespace(images=images, told=told, run=run)


def test_renders_of_any_renderer_become_a_view(tmp_path, renders):
    renders.run("room_v3.npz", "--reference", "ref.exr", "--error", "0.02")
    view = read_view(tmp_path / "room_v3.npz")
    assert (view["scene"], view["relerr"], [count for count, _ in view["noisy"]]) == ("room", 0.02, [4])
    for found, image in zip((view["ref"], view["noisy"][0][1]), renders.images):
        np.testing.assert_allclose(found[:3], image[:3], rtol=2**-6, atol=1e-6)
        np.testing.assert_allclose(found[3:], image[3:], atol=1 / 60)


def test_renders_without_features_or_with_a_wrong_name_are_refused(tmp_path, renders):
    with pytest.raises(SystemExit):
        renders.run("room.npz", "--reference", "ref.exr")
    for name in FEATURES:
        renders.told[name] = None
    with pytest.raises(SystemExit, match="no color and no albedo and no normal"):
        renders.run("room_v3.npz", "--reference", "ref.exr")
    assert not (tmp_path / "room_v3.npz").exists()


def test_every_scene_is_in_one_part_and_stays_there():
    views = [dict(scene=f"s{i:06d}") for i in range(1000)]
    parts = {name: part(views, name) for name in ("train", "val", "test")}
    assert sum(map(len, parts.values())) == 1000
    assert [round(len(p), -2) for p in parts.values()] == [800, 100, 100]
    assert part(views[:500], "test") == [v for v in parts["test"] if v in views[:500]]


def test_no_two_renders_share_a_seed():
    keys = [(s, v, p, i) for s in ("a1", "a2", "1a") for v in range(3) for p in range(3) for i in range(4)]
    assert len({int(seed_sequence(*key).generate_state(1)[0]) for key in keys}) == len(keys)
    assert sample_counts("random:3", "a1", 0) == sample_counts("random:3", "a1", 0)


@pytest.mark.parametrize("kind", kinds.KINDS)
def test_every_kind_makes_scenes_that_can_be_built(kind):
    scene = kinds.random_scene(5, kind)
    assert scene.kind == kind and scene.cameras
    for i in scene.instances:
        vertices, faces = i.mesh.vertices, i.mesh.faces
        assert np.isfinite(vertices).all() and 0 <= faces.min() <= faces.max() < len(vertices)
        assert (i.material.texture is None and i.material.bump is None) or i.mesh.uvs is not None


def test_most_scenes_have_bump_maps_of_moderate_slope_on_each_mesh():
    slopes = [slope for seed in range(12) for slope in bump_slopes(kinds.random_scene(seed))]
    assert len(slopes) > 12 and 0.09 < min(slopes) < 0.3 < max(slopes) < 1.1


def bump_slopes(scene):
    """The root mean square slope of each bump map on the first instance that has it."""
    first = {id(i.material): i for i in reversed(scene.instances) if i.material.bump is not None}
    for i in first.values():
        pixel = meshes.uv_size(i.mesh, i.matrix) / len(i.material.bump)
        yield np.sqrt(sum((np.square(g).mean() for g in np.gradient(i.material.bump, pixel)), 0.0))


def test_a_unit_of_uv_spans_the_size_of_the_transformed_mesh():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    square = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), uvs=4 * corners[:, :2])
    assert meshes.uv_size(square, np.diag([2.0, 2.0, 2.0, 1.0])) == pytest.approx(0.5)


def test_scenes_of_animations_are_numbers_and_single_ones_may_have_a_change():
    assert [scenes_of(text) for text in ("3:5", "3", "3-cut")] == [[(3, None), (4, None)], [(3, None)], [(3, "cut")]]
    with pytest.raises(ValueError):
        scenes_of("cut")


def test_crops_are_finite_and_their_light_is_what_the_input_encodes(random):
    def view(name):
        image = torch.rand(9, 40, 48, generator=random)
        noisy = torch.cat([image[:3] * (1 + torch.randn(3, 40, 48, generator=random)).clamp(min=0), image[3:]])
        return dict(name=name, ref=image, target=image[:3], noisy=[(2, noisy), (4, image)], relerr=0.1)

    crops = Crops([view("a"), view("b")], 32, 1)
    for _ in range(40):
        x, light, target = crops.batch(4)
        assert x.isfinite().all() and light.isfinite().all() and target.isfinite().all() and target.max() <= 1
        torch.testing.assert_close(x[:, :3], transfer(light[:, :3].clamp(min=0)))


@pytest.mark.parametrize(("effects", "changes"), [(0.0, False), (1.0, True)])
def test_crops_without_effects_are_the_views_own_light(effects, changes):
    gray = torch.full((9, 40, 40), 0.25)
    view = dict(name="a", ref=gray, target=gray[:3], noisy=[(2, gray)], relerr=0.1)
    crops = Crops([view], 32, 1, effects)
    seen = [torch.stack([light[:, :3].std(), transfer(light[:, :3]).sub(target).abs().max()])
            for _, light, target in (crops.batch(1) for _ in range(40))]
    assert bool((torch.stack(seen) > 1e-4).any()) == changes


def test_half_of_the_filtered_crops_have_fireflies_spread_by_the_filter(monkeypatch):
    gray = torch.full((9, 40, 40), 0.5)
    crops = Crops([dict(name="a", ref=gray, target=gray[:3], noisy=[(2, gray)], relerr=0.1)], 32, 1)
    monkeypatch.setattr(crops, "_happens", lambda odds: odds == 0.15)  # the filter, and features without noise
    _, light, target = crops.batch(64)
    brighter = (light[:, :3] > 1.01 * inverse(target)).any(1).sum((1, 2))  # pixels by crop
    assert 0.35 < (brighter > 0).float().mean() < 0.65
    assert brighter[brighter > 0].float().median() > 8  # more than unfiltered fireflies
    assert target.std((2, 3)).max() < 1e-6


@pytest.mark.parametrize("level", [0.01, 1.0, 100.0])
def test_renders_nearly_as_good_as_the_reference_are_left_out(level, random):
    target = torch.full((3, 48, 48), level)

    def render(samples):
        return (samples, target + 0.2 * level / samples**0.5 * torch.randn(target.shape, generator=random))

    def kept(*counts):
        view = dict(target=target, ref=render(64)[1], noisy=[render(count) for count in counts])
        return [samples for samples, _ in noisier(view)]

    assert kept(1, 4, 12, 24, 64) == [1, 4, 12]
    assert kept(32, 64) == [32]
    view = dict(target=target, ref=target, noisy=[render(256)])
    assert noisier(view) == view["noisy"]
