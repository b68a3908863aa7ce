"""Tests of the training code. Run `pytest` in this folder; they take seconds and need no data."""

import numpy as np
import pytest
import torch

from augment import splat, texture
from export import save_weights
from losses import LOSSES
from model import UNet
from optimizer import orthogonal
from render import kinds
from render.job import sample_counts, seed_sequence
from run import load_checkpoint
from transfer import fill, inverse, repair, transfer
from views import part, read_view
from widen import widen
from write_view import write_view


@pytest.fixture
def random():
    return torch.Generator().manual_seed(1)


def test_bad_pixels_are_filled_from_the_nearest_good_ones():
    row = torch.tensor([6, torch.nan, torch.inf, -torch.inf, torch.nan]).expand(3, 1, 5).clone()
    assert fill(row)[0, 0].tolist() == [6, 6, 6, 0, 0]
    row[1, 0, 3] = 2  # one bad channel makes a bad pixel
    assert fill(row)[1, 0].tolist() == [6, 6, 6, 0, 0]


def test_outliers_are_limited_by_their_neighbors_and_lamps_stay():
    image = torch.full((3, 9, 9), 0.2)
    image[:, 1, 1], image[:, 6:8, 6:8] = 1e9, 1e4
    repaired = repair(image, 1.0)
    torch.testing.assert_close(repaired[:, 1, 1], torch.full((3,), 16 * 0.2))
    assert (repaired[:, 6:8, 6:8] == 1e4).all() and ((repaired != image).sum() == 3)


def test_a_wider_network_is_the_same_function(random):
    narrow = UNet((4, 6, 10)).eval()
    wide = UNet((7, 6, 16)).eval()
    wide.load_state_dict(widen(narrow.state_dict(), narrow.widths, wide.widths, random))
    x = torch.rand(2, 9, 16, 24, generator=random)
    torch.testing.assert_close(wide(x), narrow(x), rtol=0, atol=1e-5)


def test_a_weights_file_is_a_checkpoint_of_the_network_that_was_exported(tmp_path):
    network, path = UNet((4, 6, 10)).eval(), tmp_path / "tiny.safetensors"
    save_weights(path, network.state_dict(), network.widths, "tiny", "one run; another")
    checkpoint = load_checkpoint(path)
    assert (checkpoint["tier"], tuple(checkpoint["widths"])) == ("tiny", network.widths)
    assert "; ".join(checkpoint["history"]) == "one run; another"
    assert checkpoint["ema"].keys() == network.state_dict().keys()
    for name, value in network.state_dict().items():
        stored = value.half() if value.ndim == 4 else value
        assert (checkpoint["ema"][name] == stored).all(), name


def test_copies_of_a_channel_are_read_with_different_weights(random):
    narrow = UNet((4, 6, 10))
    wide = widen(narrow.state_dict(), (4, 6, 10), (8, 6, 10), random)
    readers = wide["out_conv.weight"].flatten(1)
    assert len({tuple(column.tolist()) for column in readers.T}) == 8


@pytest.mark.parametrize("name", LOSSES)
def test_losses_are_zero_for_the_target_and_grow_with_the_error(name, random):
    target = torch.rand(1, 3, 64, 64, generator=random) * 0.5
    noise = torch.randn(target.shape, generator=random)
    values = [float(LOSSES[name](target + s * noise, target)) for s in (0.0, 0.01, 0.05)]
    assert abs(values[0]) < 1e-6
    assert values[0] < values[1] < values[2]


@pytest.mark.parametrize("shape", [(8, 8), (8, 20), (20, 8)])
def test_muon_steps_have_singular_values_near_one(shape, random):
    values = torch.linalg.svdvals(orthogonal(torch.randn(shape, generator=random)).float())
    assert 0.4 < values.min() <= values.max() < 1.4


def test_textures_alternate_and_keep_the_mean():
    for kind, [along_x, along_y] in enumerate([(True, True), (True, False), (False, True)]):
        pattern = texture(12, 2, kind, 0.25)[0]
        assert pattern.mean().item() == pytest.approx(1) and pattern.unique().numel() == 2
        assert pattern.max().item() == pytest.approx(4 * pattern.min().item())
        assert pattern[0, 0] == pattern[1, 1] and (pattern[0, 0] != pattern[0, 2]) == along_x
        assert (pattern[0, 0] != pattern[2, 0]) == along_y


def test_splatting_keeps_the_mean_and_correlates_neighbors(random):
    noise = torch.randn(3, 64, 64, generator=random)
    blurred = splat(noise, 0.6)
    assert abs(float(blurred.mean() - noise.mean())) < 0.01
    left, right = blurred[:, :, 1:].flatten(), blurred[:, :, :-1].flatten()
    assert torch.corrcoef(torch.stack([left, right]))[0, 1] > 0.3
    torch.testing.assert_close(splat(torch.ones(3, 9, 9), 0.6), torch.ones(3, 9, 9))


def test_the_transfer_function_has_its_inverse():
    y = torch.logspace(-6, 4.8, 200, dtype=torch.float64)
    torch.testing.assert_close(inverse(transfer(y)), y, rtol=1e-6, atol=1e-9)


def test_a_view_is_read_as_it_was_written(tmp_path, random):
    image = torch.rand(9, 24, 32, generator=random).numpy()
    image[:3] *= 50
    write_view(tmp_path / "room000003_v1.npz", image, [(4, image * 0.5)], kind="room", ref_relerr=0.1)
    view = read_view(tmp_path / "room000003_v1.npz")
    assert (view["scene"], view["kind"], view["relerr"], view["noisy"][0][0]) == ("room000003", "room", 0.1, 4)
    np.testing.assert_allclose(view["ref"][:3], image[:3], rtol=2**-7)
    np.testing.assert_allclose(view["ref"][3:], image[3:], atol=1 / 127)
    np.testing.assert_allclose(view["noisy"][0][1][:3], image[:3] * 0.5, rtol=2**-6)


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
        assert i.material.texture is None or i.mesh.uvs is not None
