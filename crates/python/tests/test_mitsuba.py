"""A Mitsuba 3 render, denoised in the same process."""

import mitsuba as mi
import numpy as np
import pytest

import wgdenoise

# This variant needs neither LLVM nor CUDA.
mi.set_variant("scalar_rgb")


@pytest.fixture(scope="module")
def render():
    """Render the Cornell box with albedo and normals, 64 × 64 pixels, at this sample count."""
    scene = mi.cornell_box()
    scene["integrator"] = {
        "type": "aov",
        "aovs": "albedo:albedo,normal:sh_normal",
        "image": {"type": "path"},
    }
    scene["sensor"]["film"]["width"] = scene["sensor"]["film"]["height"] = 64
    # A box filter gives each pixel its own samples, so that neighbors' noise is independent.
    scene["sensor"]["film"]["rfilter"] = {"type": "box"}
    scene = mi.load_dict(scene)
    return lambda samples: mi.render(scene, spp=samples)


def test_a_render_comes_closer_to_its_reference_than_with_twice_the_samples(denoiser, render):
    noisy, more, reference = render(4), render(8)[:, :, :3], render(256)[:, :, :3]
    color, albedo, normal = noisy[:, :, :3], noisy[:, :, 3:6], noisy[:, :, 6:9]
    assert not isinstance(color, np.ndarray)
    clean = denoiser.denoise(color, albedo, normal)
    found, expected = wgdenoise.compare(clean, reference), wgdenoise.compare(more, reference)
    assert found.l1 < expected.l1 and found.ssim > expected.ssim, f"{found} against {expected}"
    same = denoiser.denoise(*[np.array(part) for part in (color, albedo, normal)])
    np.testing.assert_array_equal(clean, same)
