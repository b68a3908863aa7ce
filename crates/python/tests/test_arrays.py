"""Which arrays are accepted, and the error messages for the others."""

import numpy as np
import pytest
from conftest import image

import wgdenoise


class Exporter:
    """An object that exports an array in exactly one way."""

    def __init__(self, array, way):
        setattr(type(self), way, lambda _, *args, **kwargs: getattr(array, way)(*args, **kwargs))
        if way == "__dlpack__":
            type(self).__dlpack_device__ = lambda _: array.__dlpack_device__()


def exporter(array, way):
    return type("Exporter", (Exporter,), {})(array, way)


def packed(array):
    """Return the array as a field of packed records, at odd addresses."""
    records = np.zeros(array.shape[:2], np.dtype([("flag", "u1"), ("color", "f4", 3)]))
    records["color"] = array
    assert not records["color"].flags.aligned
    return records["color"]


@pytest.mark.parametrize(
    "same",
    [
        lambda a: a.astype(np.float16),
        lambda a: a.astype(np.float64),
        np.asfortranarray,
        lambda a: np.repeat(np.repeat(a, 2, axis=0), 3, axis=1)[::2, ::3],
        lambda a: np.ascontiguousarray(a[::-1, ::-1, ::-1])[::-1, ::-1, ::-1],
        lambda a: np.ascontiguousarray(a.transpose(2, 0, 1)).transpose(1, 2, 0),
        lambda a: np.dstack([a, a])[..., :3],
        packed,
        lambda a: exporter(a, "__array__"),
        lambda a: exporter(a, "__dlpack__"),
    ],
    ids="f16 f64 fortran strided reversed planar sliced packed array dlpack".split(),
)
def test_every_type_and_layout_of_an_image_gives_the_same_bits(denoiser, noisy, same):
    found = denoiser.denoise(same(noisy), same(noisy), same(noisy))
    np.testing.assert_array_equal(found, denoiser.denoise(noisy, noisy, noisy))


def test_the_result_is_a_new_array_and_the_input_stays_as_it_is(denoiser, noisy):
    before = noisy.copy()
    noisy.flags.writeable = False
    found = denoiser.denoise(noisy)
    assert found.dtype == np.float32 and found.shape == noisy.shape
    assert found.flags.writeable and found.flags.c_contiguous
    np.testing.assert_array_equal(noisy, before)
    assert found.std() < 0.5 * noisy.std()


def test_bytes_are_decoded_by_the_srgb_curve_of_iec_61966_2_1(denoiser):
    codes = np.random.default_rng(2).integers(0, 256, (40, 56, 3), np.uint8)
    values = codes / 255
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    found = denoiser.denoise(codes, codes, layers=[codes], srgb=True)
    expected = denoiser.denoise(linear, linear, layers=[linear])
    np.testing.assert_array_equal(found.color, expected.color)
    np.testing.assert_array_equal(found.layers[0], expected.layers[0])


@pytest.mark.parametrize(
    ("array", "sentence"),
    [
        (None, "color is a NoneType, expected a NumPy array, or an object with __array__ or __dlpack__"),
        ([[[0.5, 0.5, 0.5]]], "color is a list, expected a NumPy array, or an object with __array__ or __dlpack__"),
        (image()[0], "color has the shape (56, 3), expected (height, width, 3) or (height, width, 4)"),
        (image(channels=2), "color has the shape (40, 56, 2)"),
        (image()[None], "color has the shape (1, 40, 56, 3)"),
        (np.float32(1), "color has the shape (), expected"),
        (image()[:0], "color is empty: its shape is (0, 56, 3)"),
        (image()[:, :0], "color is empty: its shape is (40, 0, 3)"),
        (image() * np.nan, "color has no finite value"),
        (image().astype(np.int32), "color has the dtype int32, expected float32, float16 or float64"),
        (image().astype(">f4"), "color has the dtype >f4"),
        (image().astype(complex), "color has the dtype complex128"),
        (image().astype(object), "color has the dtype object"),
        (image().astype(np.uint8), "color has the dtype uint8"),
        (exporter(np.array("text"), "__array__"), "color has the shape ()"),
    ],
)
def test_an_array_that_cannot_be_used_is_one_sentence(denoiser, array, sentence):
    with pytest.raises(wgdenoise.ImageError) as caught:
        denoiser.denoise(array)
    assert sentence in str(caught.value) and "\n" not in str(caught.value)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, wgdenoise.Error)


def test_the_other_images_are_named_in_messages(denoiser, noisy):
    small, bytes_ = noisy[1:], noisy.astype(np.uint8)
    for arguments, sentence in [
        ({"albedo": small}, "albedo is 56×39, but the color is 56×40"),
        ({"normal": small}, "normal is 56×39"),
        ({"albedo": image(channels=4)}, "albedo has the shape (40, 56, 4), expected (height, width, 3)"),
        ({"normal": noisy * np.nan}, "normal has no finite value"),
        ({"layers": {"sun": noisy[..., 0]}}, "layer `sun` has the shape (40, 56)"),
        ({"layers": [noisy, noisy[..., :2]]}, "layer 1 has the shape (40, 56, 2)"),
        ({"layers": [small]}, "a layer is 56×39"),
        ({"alpha": small[..., 0]}, "alpha has the shape (39, 56), expected (40, 56)"),
        ({"alpha": noisy}, "alpha has the shape (40, 56, 3)"),
        ({"normal": bytes_, "albedo": bytes_, "srgb": True}, "normal has the dtype uint8"),
    ]:
        with pytest.raises(wgdenoise.ImageError) as caught:
            denoiser.denoise(noisy, **arguments)
        assert sentence in str(caught.value)


def test_srgb_without_bytes_and_bytes_with_alpha_are_refused(denoiser, noisy):
    with pytest.raises(wgdenoise.UsageError, match="there is none"):
        denoiser.denoise(noisy, srgb=True)
    with pytest.raises(wgdenoise.ImageError, match="of three channels"):
        denoiser.denoise(image(channels=4).astype(np.uint8), srgb=True)


def test_an_object_that_fails_to_hand_out_its_array_is_named_with_its_reason(denoiser):
    class OnAnotherDevice:
        def __array__(self, dtype=None, copy=None):
            raise TypeError("copy it to host memory first")

    with pytest.raises(wgdenoise.ImageError, match="color cannot be read.*copy it to host") as caught:
        denoiser.denoise(OnAnotherDevice())
    assert isinstance(caught.value.__cause__, TypeError)


def test_broken_pixels_are_repaired(denoiser, noisy):
    noisy[5, 5], noisy[20, 30] = np.nan, np.inf
    assert np.isfinite(denoiser.denoise(noisy)).all()
    huge = noisy.astype(np.float64)
    huge[9, 9] = 1e300
    assert np.isfinite(denoiser.denoise(huge)).all()
