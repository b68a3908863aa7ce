"""Beyond single images: layers, alpha, interruption, threads, memory."""

import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from conftest import WEIGHTS, image

import wgdenoise


@pytest.fixture(scope="module")
def tiled():
    """A denoiser whose progress has many steps."""
    return wgdenoise.Denoiser("fast", tile=272)


def test_the_function_gives_what_the_class_gives(denoiser, noisy):
    found = wgdenoise.denoise(noisy, noisy, quality="fast", precision="f16", device=0)
    np.testing.assert_array_equal(found, denoiser.denoise(noisy, noisy))


def test_auxiliary_images_quality_and_precision_matter(denoiser, noisy):
    plain = denoiser.denoise(noisy)
    variants = [
        denoiser.denoise(noisy, albedo=noisy),
        denoiser.denoise(noisy, normal=noisy),
        denoiser.denoise(noisy, input_scale=7.0),
        denoiser.denoise(noisy, panorama=True),
        wgdenoise.denoise(noisy, quality="balanced"),
        wgdenoise.denoise(noisy, quality="fast", precision="f32"),
        wgdenoise.denoise(noisy, weights=WEIGHTS),
    ]
    for variant in variants:
        assert (variant != plain).any()


def test_layers_come_back_as_they_were_given_and_add_up(denoiser, noisy):
    sun = noisy * image(seed=3)
    found = denoiser.denoise(noisy, layers={"sun": sun, "sky": noisy - sun})
    assert list(found.layers) == ["sun", "sky"] and found.alpha is None
    np.testing.assert_allclose(found.layers["sun"] + found.layers["sky"], found.color, atol=1e-5)
    listed = denoiser.denoise(noisy, layers=[sun, noisy - sun])
    np.testing.assert_array_equal(listed.layers[0], found.layers["sun"])
    assert denoiser.denoise(noisy, layers=[]).layers == []


def test_alpha_is_denoised_alike_as_a_fourth_channel_and_by_itself(denoiser):
    rgba = image(channels=4)
    apart = denoiser.denoise(rgba[..., :3], alpha=rgba[..., 3])
    together = denoiser.denoise(rgba)
    np.testing.assert_array_equal(together, np.dstack([apart.color, apart.alpha]))
    assert apart.alpha.std() < 0.5 * rgba[..., 3].std()
    column = denoiser.denoise(rgba[..., :3], alpha=rgba[..., 3:])
    np.testing.assert_array_equal(column.alpha, apart.alpha)


def test_alpha_of_0_and_1_stays_and_leaves_the_color_to_itself(denoiser, noisy):
    alpha = (noisy[..., :1] > 0.5).astype(np.float32)
    found = denoiser.denoise(np.dstack([noisy, alpha]))
    np.testing.assert_array_equal(found, np.dstack([denoiser.denoise(noisy), alpha]))


def test_two_alphas_are_refused(denoiser):
    rgba = image(channels=4)
    with pytest.raises(wgdenoise.UsageError, match="given twice"):
        denoiser.denoise(rgba, alpha=rgba[..., 3])


@pytest.mark.parametrize(
    ("arguments", "error", "sentence"),
    [
        ({"quality": "best"}, wgdenoise.UsageError, "quality is best, expected fast, balanced or high"),
        ({"precision": "f8"}, wgdenoise.UsageError, "precision is f8, expected f16 or f32"),
        ({"tile": 0}, wgdenoise.UsageError, "tile is 0"),
        ({"timeout": -1.0}, wgdenoise.UsageError, "timeout is -1"),
        ({"timeout": float("nan")}, wgdenoise.UsageError, "timeout is NaN"),
        ({"quality": "high", "weights": WEIGHTS}, wgdenoise.UsageError, "give it or weights"),
        ({"weights": __file__}, wgdenoise.FileError, "is not a weights file"),
        ({"weights": "no such file"}, wgdenoise.FileError, "no such file"),
        ({"device": "no such GPU"}, wgdenoise.AdapterError, "`no such GPU` matches none"),
        ({"device": 99}, wgdenoise.AdapterError, "`99` matches none"),
        ({"tile": "wide"}, TypeError, "tile"),
    ],
)
def test_settings_that_cannot_be_used_are_one_sentence(arguments, error, sentence):
    with pytest.raises(error) as caught:
        wgdenoise.Denoiser(**arguments)
    assert sentence in str(caught.value)


def test_memory_that_is_too_small_is_an_error(noisy):
    denoiser = wgdenoise.Denoiser("fast", memory_bytes=1000)
    with pytest.raises(wgdenoise.OutOfMemoryError) as caught:
        denoiser.denoise(noisy)
    assert isinstance(caught.value, MemoryError)


def test_images_in_a_row_do_not_depend_on_kept_memory(noisy):
    keeps, frees = (wgdenoise.Denoiser("fast", keep_memory=keep) for keep in (True, False))
    for color, albedo in [(noisy, noisy), (noisy * 0.01, noisy), (noisy, None)]:
        np.testing.assert_array_equal(keeps.denoise(color, albedo), frees.denoise(color, albedo))


def test_an_input_scale_of_0_is_refused(denoiser, noisy):
    with pytest.raises(wgdenoise.ImageError, match="input scale is 0"):
        denoiser.denoise(noisy, input_scale=0.0)


def test_weights_without_a_pyramid_refuse_layers(noisy):
    denoiser = wgdenoise.Denoiser(weights=WEIGHTS)
    with pytest.raises(wgdenoise.WeightsError, match="kernel pyramid"):
        denoiser.denoise(noisy, layers=[noisy])


def test_tiles_give_the_same_bits_as_the_whole_image(denoiser, tiled):
    large = image(400, 300)
    np.testing.assert_array_equal(tiled.denoise(large), denoiser.denoise(large))


def test_progress_rises_to_the_total(denoiser, noisy):
    steps = []
    denoiser.denoise(noisy, progress=lambda done, total: steps.append((done, total)))
    assert steps == sorted(steps) and steps[-1][0] == steps[-1][1] == steps[0][1]


def test_what_the_callback_raises_ends_the_run_and_the_next_one_is_whole(tiled, noisy):
    calls = []

    def fail(done, total):
        calls.append(done)
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        tiled.denoise(image(400, 300), progress=fail)
    assert len(calls) == 1
    assert tiled.denoise(noisy).shape == noisy.shape


def test_ctrl_c_is_a_keyboard_interrupt_before_the_end(tiled):
    steps = {}

    def interrupt():
        while not steps:
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    # The callback is compiled code, where Python does not check for signals.
    with pytest.raises(KeyboardInterrupt):
        tiled.denoise(image(400, 300), progress=steps.__setitem__)
    thread.join()
    assert max(steps) < steps[max(steps)]


def test_other_threads_run_meanwhile(tiled):
    steps, seen = {}, []

    def watch():
        while not steps:
            time.sleep(0.001)
        seen.append(max(steps))

    thread = threading.Thread(target=watch)
    thread.start()
    # The callback is compiled code, where Python does not switch threads.
    tiled.denoise(image(400, 300), progress=steps.__setitem__)
    thread.join()
    assert seen[0] < max(steps)


def test_threads_share_a_denoiser(denoiser):
    images = [image(seed=seed) for seed in range(4)]
    expected = [denoiser.denoise(noisy) for noisy in images]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(denoiser.denoise, images * 3))
    for index, result in enumerate(found):
        np.testing.assert_array_equal(result, expected[index % 4])


def test_memory_does_not_grow_over_200_calls():
    denoiser, noisy = wgdenoise.Denoiser(weights=WEIGHTS), image(128, 128)
    for _ in range(20):
        denoiser.denoise(noisy, noisy, noisy)
    before = resident_bytes()
    for _ in range(200):
        denoiser.denoise(noisy, noisy, noisy)
    # Leaking one image per call would add up to 200.
    assert resident_bytes() - before < 20 * noisy.nbytes


def resident_bytes():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def test_devices_and_metrics_have_names(noisy):
    device = wgdenoise.devices()[0]
    assert device.number == 0 and wgdenoise.Denoiser("fast", device=device.name).device == device.name
    same = wgdenoise.compare(noisy, noisy)
    assert (same.l1, same.psnr, same.ssim, same.bad) == (0, 120, 1, 0)
    # The values 4 and 2 become 0.36 and 0.18 after exposure.
    other = wgdenoise.compare(np.full((2, 3, 3), 4.0), np.full((2, 3, 3), 2.0))
    assert other.smape == pytest.approx(0.18 / 0.55)
    with pytest.raises(wgdenoise.ImageError, match="cannot be compared"):
        wgdenoise.compare(noisy, noisy[1:])


def test_a_denoiser_shows_where_it_runs(denoiser):
    assert denoiser.device in repr(denoiser) and denoiser.kernels in repr(denoiser)
