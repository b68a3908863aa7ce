"""Tests of the training code. Run `pytest` in this folder; they take seconds and need no data."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from safetensors.numpy import load_file

from augment import splat, texture
from average import average
from export import provenance, save_weights
from inference import denoise
from losses import LOSSES
from make_fixtures import bad_pixels, kernel_files
from model import Gather, KernelPyramid, UNet, gather, network_for, with_demodulation
from optimizer import orthogonal
from quality import brisque, harm, ranking, rbf, scene_statistics
from quality.networks import Network
from run import load_checkpoint
from train import Validation
from transfer import autoexposure, fill, inverse, network_input, repair, transfer


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
    repaired, valid = repair(image, 1.0)
    torch.testing.assert_close(repaired[:, 1, 1], torch.full((3,), 256 * 0.2))
    assert (repaired[:, 6:8, 6:8] == 1e4).all() and ((repaired != image).sum() == 3) and (valid == 1).all()


def test_suns_of_infinite_light_are_very_bright_and_fewer_pixels_are_fireflies():
    image = torch.full((3, 9, 9), 0.2)
    image[1, 4:6, 4:6], image[2, 0, :3] = torch.inf, torch.inf
    repaired, _ = repair(image, 1.0)
    assert (repaired[1, 4:6, 4:6] == 65504).all() and (repaired[0, 4:6, 4:6] == image[0, 4:6, 4:6]).all()
    torch.testing.assert_close(repaired[:, :3], torch.full((3, 3, 9), 0.2))


def test_missing_pixels_are_filled_and_holes_are_not_valid():
    image = torch.full((3, 9, 20), 0.5)
    image[0, :, :7], image[:, 4, 15] = torch.nan, -torch.inf
    repaired, valid = repair(image, 1.0)
    assert (repaired[:, :, 5:] == 0.5).all() and (repaired[:, :, :5] == 0).all()
    assert (valid[0, :, 5:] == 1).all() and (valid[0, :, :5] == 0).all()


def test_only_light_of_negative_luminance_is_broken():
    image = torch.full((3, 3, 3), 0.2)
    image[:, 0, 0], image[:, 2, 2] = torch.tensor([-0.1, 0.5, 0.0]), torch.tensor([0.1, -0.5, 0.0])
    repaired, _ = repair(image, 1.0)
    torch.testing.assert_close(repaired[:, 0, 0], torch.tensor([-0.1, 0.5, 0.0]))
    torch.testing.assert_close(repaired[:, 2, 2], torch.tensor([0.1, 0.0, 0.0]))
    encoded, light = network_input(image, None, None, 2.0)
    assert encoded[0, 0, 0] == 0 and light[:, 0, 0].tolist() == pytest.approx([-0.2, 1.0, 0.0, 1.0])


@pytest.mark.parametrize("dark", [0.0, 1e-6, 1e-4])
def test_a_dark_surrounding_does_not_change_the_exposure(dark, random):
    scene = torch.rand(3, 48, 48, generator=random)
    image = torch.full((3, 96, 160), dark)
    image[:, 16:64, 32:80] = scene
    assert autoexposure(image) == pytest.approx(autoexposure(scene), rel=1e-6)
    assert autoexposure(image * 2.0**-20) == pytest.approx(autoexposure(image) * 2.0**20, rel=1e-6)


NETWORKS = [UNet, KernelPyramid]


def scene(random, *shape):
    """Network input and light of random pixels."""
    x, color = torch.rand(*shape[:-3], 9, *shape[-2:], generator=random), torch.rand(shape, generator=random)
    return x, torch.cat([color, torch.ones_like(color[..., :1, :, :])], -3)


def network(widths, random, demodulates=False):
    """A KernelPyramid with random weights, whose kernels differ from pixel to pixel."""
    torch.manual_seed(int(torch.randint(2**31, (), generator=random)))
    model = KernelPyramid(widths, demodulates=demodulates).eval()
    for name, p in model.named_parameters():
        if name.startswith("kernel_conv"):
            p.data.copy_(torch.randn(p.shape, generator=random))
    return model


def test_constant_light_stays_of_any_level_and_hue(random):
    model = network((4, 6, 8), random)
    x, light = scene(random, 1, 3, 24, 32)
    for color in ([1e-6, 0.0, 2e-6], [0.3, 0.2, 0.1], [0.0, 6e4, -1.0]):
        light[:, :3] = torch.tensor(color).view(3, 1, 1)
        out = model(x, light)
        torch.testing.assert_close(out, light[:, :3], rtol=1e-6, atol=0)


def test_the_output_is_linear_in_the_light_and_within_its_range(random):
    model = network((4, 6, 8), random)
    x, first = scene(random, 1, 3, 24, 32)
    second = scene(random, 1, 3, 24, 32)[1]
    mixed = torch.cat([3 * first[:, :3] + second[:, :3], first[:, 3:]], 1)
    torch.testing.assert_close(model(x, mixed), 3 * model(x, first) + model(x, second))
    assert first[:, :3].min() <= model(x, first).min() and model(x, first).max() <= first[:, :3].max()


def test_missing_light_is_not_gathered(random):
    model = network((4, 6, 8), random)
    x, light = scene(random, 1, 3, 24, 32)
    light[:, :3] = 0.5
    light[..., 4:9, 5:20] = 0
    torch.testing.assert_close(model(x, light), torch.full((1, 3, 24, 32), 0.5))
    assert (model(x, torch.zeros_like(light)) == 0).all()


def plain(model):
    """The same network without demodulation."""
    state, last = model.state_dict(), ("kernel_conv0.weight", "kernel_conv0.bias")
    found = KernelPyramid(model.widths).eval()
    found.load_state_dict(state | {name: state[name][:-1] for name in last})
    return found


def at_power(power, model, x, light):
    """The result of a demodulating network with the same power at every pixel."""
    model.kernel_conv0.weight.data[-1], model.kernel_conv0.bias.data[-1] = 0, torch.logit(torch.tensor(power)) / 8
    return model(x, light)


def test_without_contrast_in_the_albedo_demodulation_changes_nothing(random):
    model = network((4, 6, 8, 8), random, demodulates=True)
    x, light = scene(random, 1, 3, 24, 32)
    for albedo in ([0.0, 0.0, 0.0], [1.0, 0.2, 0.0]):
        x[:, 3:6] = torch.tensor(albedo).view(3, 1, 1)
        torch.testing.assert_close(at_power(0.5, model, x, light), plain(model)(x, light), rtol=1e-5, atol=0)
    x[:, 3:6, 8:12, 8:12] = 0.7
    assert (at_power(0.5, model, x, light) - plain(model)(x, light)).abs().max() > 0.01


def test_light_on_a_textured_albedo_comes_back_even_where_it_is_missing(random):
    model = network((4, 6, 8, 8), random, demodulates=True)
    x, light = scene(random, 1, 3, 24, 32)
    lit = torch.tensor([2.0, 0.5, 1e-3]).view(3, 1, 1) * (x[:, 3:6] + 0.05)
    light[:, :3] = lit
    light[..., 4:9, 5:20] = 0
    torch.testing.assert_close(at_power(1.0, model, x, light), lit, rtol=1e-5, atol=0)


@pytest.mark.parametrize("power", [0.25, 0.75])
def test_the_power_leads_from_the_plain_mean_to_the_whole_texture(power, random):
    model = network((4, 6, 8, 8), random, demodulates=True)
    x, light = scene(random, 1, 3, 24, 32)
    none, some, whole = (at_power(p, model, x, light) for p in (0.0, power, 1.0))
    torch.testing.assert_close(none, plain(model)(x, light), rtol=1e-5, atol=0)
    torch.testing.assert_close(some, none ** (1 - power) * whole**power, rtol=1e-5, atol=0)


def test_a_demodulating_network_is_linear_in_the_light_and_recognized_by_its_tensors(random):
    model = network((4, 6, 8), random, demodulates=True)
    x, first = scene(random, 1, 3, 24, 32)
    second = scene(random, 1, 3, 24, 32)[1]
    mixed = torch.cat([3 * first[:, :3] + second[:, :3], first[:, 3:]], 1)
    torch.testing.assert_close(model(x, mixed), 3 * model(x, first) + model(x, second))
    for one in (model, network((4, 6, 8), random)):
        found = network_for("kernel-pyramid", (4, 6, 8), one.state_dict())
        assert found.demodulates == one.demodulates
        added = with_demodulation(one.state_dict())
        KernelPyramid((4, 6, 8), demodulates=True).load_state_dict(added)
        assert torch.equal(added["kernel_conv0.weight"][:11], one.kernel_conv0.weight[:11])


def test_gathering_repeats_the_border_and_has_the_right_derivative(random):
    light, kernels = (torch.randn(1, c, 4, 5, generator=random).double().requires_grad_() for c in (4, 9))
    wide = torch.nn.functional.pad(light, (1, 1, 1, 1), mode="replicate")
    patches = torch.nn.functional.unfold(wide, 3).view(1, 4, 9, 4, 5)
    torch.testing.assert_close(Gather.apply(light, kernels), (patches * kernels[:, None]).sum(2))
    assert torch.autograd.gradcheck(Gather.apply, (light, kernels))


def test_any_weights_and_fireflies_give_finite_colors_and_derivatives(random):
    model = network((4, 4, 4, 4, 4), random)
    for p in model.parameters():
        p.data *= 4
    x, light = scene(random, 1, 3, 32, 32)
    light[:, :3, 5, 6] = 65504
    out = model(x, light)
    out.sum().backward()
    assert out.isfinite().all() and all(p.grad.isfinite().all() for p in model.parameters())


@pytest.mark.parametrize("kind", NETWORKS)
def test_a_render_of_any_size_with_bad_pixels_is_denoised(kind, random):
    model = kind((4, 6, 8)).eval()
    image = torch.rand(9, 13, 22, generator=random)
    image[0, 3, 4], image[1, 5, 6], image[4, 7, 8] = torch.nan, torch.inf, torch.nan
    for inputs in ("color", "color,albedo,normal"):
        result = denoise(model, image, inputs)
        assert result.shape == (3, 13, 22) and result.isfinite().all()


@pytest.mark.parametrize("kind", NETWORKS)
def test_a_weights_file_is_a_checkpoint_of_the_network_that_was_exported(kind, tmp_path):
    network, path = kind((4, 6, 10)).eval(), tmp_path / "tiny.safetensors"
    save_weights(path, network.state_dict(), network.topology, network.widths, "tiny", "one run; another")
    checkpoint = load_checkpoint(path)
    assert isinstance(Network(path).model, kind)
    about = checkpoint["tier"], checkpoint["topology"], tuple(checkpoint["widths"])
    assert about == ("tiny", network.topology, network.widths)
    assert "; ".join(checkpoint["history"]) == "one run; another"
    assert checkpoint["ema"].keys() == network.state_dict().keys()
    for name, value in network.state_dict().items():
        stored = value.half() if value.ndim == 4 else value
        assert (checkpoint["ema"][name] == stored).all(), name


def test_an_exported_history_is_continued_without_its_data_and_license(tmp_path, random):
    network = KernelPyramid((4, 6))
    options = SimpleNamespace(data="renders; of scenes", license="MIT OR Apache-2.0")
    text = provenance(dict(history=["one run; norm frozen", "another"]), options)
    save_weights(tmp_path / "a.safetensors", network.state_dict(), network.topology, network.widths, "a", text)
    assert load_checkpoint(tmp_path / "a.safetensors")["history"] == ["one run; norm frozen; then another"]


def test_an_average_has_the_weighted_means_of_all_weights_and_statistics(random):
    networks = [network((4, 6, 10), random) for _ in range(2)]
    of = lambda n, name: dict(topology=n.topology, widths=n.widths, tier="fast", history=list(name), ema=n.state_dict())
    found = average([of(networks[0], "a"), of(networks[1], "b")], [1.0, 3.0])
    for name, value in found["ema"].items():
        first, second = (n.state_dict()[name] for n in networks)
        torch.testing.assert_close(value, 0.25 * first + 0.75 * second)
    KernelPyramid((4, 6, 10)).load_state_dict(found["ema"], strict=False)
    assert found["history"] == ["the average of 25% after (a) and 75% after (b)"]
    found = average([of(networks[0], "ab"), of(networks[1], "abcd")], [1.0, 3.0])
    assert found["history"] == ["a", "b", "the average of 25% of these and 75% after (c; then d)"]
    for other in (KernelPyramid((4, 6, 8)), KernelPyramid((4, 6, 10), demodulates=True)):
        with pytest.raises(SystemExit, match="differ in topology, widths or demodulation"):
            average([of(networks[0], "a"), of(other, "c")], [1, 1])


@pytest.mark.parametrize("name", LOSSES)
def test_losses_are_zero_for_the_target_and_grow_with_the_error(name, random):
    target = torch.rand(1, 3, 64, 64, generator=random) * 0.5
    noise = torch.randn(target.shape, generator=random)
    values = [float(LOSSES[name](target + s * noise, target)) for s in (0.0, 0.01, 0.05)]
    assert abs(values[0]) < 1e-6
    assert values[0] < values[1] < values[2]


def test_the_relative_loss_alone_sees_errors_above_the_displays_white():
    light = torch.full((1, 3, 64, 64), 4.0)
    light[..., ::2] = 8.0
    shifted = light.roll(1, -1)  # the same mean light, as bright on a display
    values = {name: float(LOSSES[name](transfer(shifted), transfer(light)))
              for name in ("display_light", "display_relative")}
    assert values["display_light"] < 1e-5 and values["display_relative"] > 0.1


@pytest.mark.parametrize("shape", [(8, 8), (8, 20), (20, 8)])
def test_muon_steps_have_singular_values_near_one(shape, random):
    values = torch.linalg.svdvals(orthogonal(torch.randn(shape, generator=random)).float())
    assert 0.4 < values.min() <= values.max() < 1.4


def test_validation_compares_with_the_target_and_not_with_the_reference(monkeypatch):
    noisy, target = torch.full((9, 32, 32), 0.1), torch.full((3, 32, 32), 0.3)
    view = dict(ref=torch.full((9, 32, 32), 0.2), target=target, noisy=[(2, noisy), (8, noisy)])
    validation = Validation([view])
    for result, score in ((target, 0), (noisy[:3], 1)):
        monkeypatch.setattr(validation, "_denoise", lambda model, image, result=result: result)
        assert validation(None) == pytest.approx(score)


def test_the_fixtures_are_finite_and_gather_what_they_say(tmp_path, random):
    repaired = bad_pixels(random)
    assert repaired["expected"].isfinite().all() and repaired["valid"].unique().tolist() == [0, 1]
    with torch.no_grad():
        files = kernel_files(tmp_path, random)
    f = files["gather"]
    torch.testing.assert_close(gather(f["light"][None], f["logits"][None], f["coarser"][None])[0], f["expected"])
    stored = Network(tmp_path / "kernel_tiny.safetensors").model
    io = {name: tensor[None].float() for name, tensor in files["kernel_tiny_io"].items()}
    torch.testing.assert_close(stored(io["input"], io["light"]), io["expected"], rtol=1e-4, atol=1e-5)


def test_textures_alternate_and_keep_the_mean():
    for start in ((0, 0), (1, 0), (1, 1)):  # every phase
        dots = texture(4, 1, 3, 0.0, start)[0]
        assert dots.mean().item() == 1 and dots.max().item() == 4 and dots[-start[1] % 2, -start[0] % 2] == 4
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


def test_the_features_of_brisque_are_those_that_the_program_is_tested_with():
    stored = load_file(Path(__file__).parents[1] / "crates/metrics/tests/brisque.safetensors")
    for name, color in brisque.pictures().items():
        np.testing.assert_allclose(stored[name], color.numpy(), rtol=1e-6)  # versions of PyTorch round differently
        color = torch.from_numpy(stored[name])
        shown = brisque.display(torch.where(color.isfinite(), color, 0).double() * stored["exposure"][0])
        found = scene_statistics.features(shown.numpy())
        np.testing.assert_allclose(found, stored[f"{name}.features"], atol=1e-9)


def test_distributions_are_found_again_in_their_samples():
    random = np.random.default_rng(1)
    for values, shape in ((random.normal(size=40000), 2), (random.laplace(size=40000), 1)):
        assert scene_statistics.symmetric(values)[0] == pytest.approx(shape, rel=0.05)
        side = abs(values)
        lopsided = np.concatenate([side, *[-3 * side] * 3])  # three times as wide on the left, and so as heavy
        expected = shape, lopsided.mean(), 9 * (side**2).mean(), (side**2).mean()
        assert scene_statistics.asymmetric(lopsided) == pytest.approx(expected, rel=0.05)
    assert scene_statistics.asymmetric(np.zeros(9)) == (10, 0, 0, 0)


def test_brisque_refuses_what_its_window_does_not_fit_into():
    with pytest.raises(ValueError, match="14x14"):
        scene_statistics.features(np.ones((3, 13, 40)))
    assert np.isfinite(scene_statistics.features(np.ones((3, 14, 14)))).all()


def test_the_regressor_learns_a_smooth_score_and_is_the_same_each_time():
    random = np.random.default_rng(1)
    features = random.uniform(0.1, 1, (400, 36))
    scores = 50 + 30 * np.tanh(features[:, 0] - np.log(features[:, 1]) - 1.5)
    parts = features[:300], scores[:300], features[300:], scores[300:]
    regressor, error = rbf.fit(*parts)
    assert error < 0.3 * scores.std()
    assert rbf.rust(rbf.fit(*parts)[0]) == rbf.rust(regressor)
    assert 0 <= regressor(features * 1e3).min() <= regressor(features * 1e3).max() <= 100


def test_ranks_are_counted_within_views():
    assert ranking.spearman([1, 2, 3, 3], [10, 20, 30, 30]) == pytest.approx(1)
    assert ranking.spearman([1, 2, 3], [3, 2, 1]) == pytest.approx(-1)
    renders = [("noisy", 2, 60, 50), ("fast", 2, 20, 55), ("noisy", 8, 40, 30), ("fast", 8, 10, 20)]
    rows = [dict(view="a", method=m, spp=n, target=t, score=s) for m, n, t, s in renders]
    rows += [dict(view="b", method="noisy", spp=32, target=1, score=99), rows[0] | dict(method="reference", score=25)]
    assert ranking.cleaned(rows) == [False, True]
    assert ranking.more_samples(rows, ["noisy", "fast"]) == [True, True]
    assert sorted(ranking.seen_pairs(rows, 10)) == [False, False, True, True, True, True]
    assert ranking.seen_pairs(rows, 45) == [True]
    assert ranking.references(rows) == [True, False]


@pytest.mark.parametrize("name", harm.HARMS)
def test_harms_keep_the_size_and_but_for_darkness_the_mean(name, random):
    image = torch.rand(3, 26, 23, generator=random)
    harmed = harm.HARMS[name](image)
    assert harmed.shape == image.shape and torch.equal(harmed, image) == (name == "nothing")
    expected = image.mean() / 2 if name == "half as bright" else image.mean()
    assert float(harmed.mean()) == pytest.approx(float(expected), abs=0.03)
