use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::ops::channel_map::ChannelMap;
use wgdenoise::internals::ops::contrast::contrast;
use wgdenoise::internals::ops::image::{Element, ImageFormat};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{Image, Precision};

use super::image::{binding, view};
use wgdenoise_testing::gpu::{PRECISIONS, buffer, context, download, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Red, green and blue of one quad.
const MAP: [Option<usize>; 4] = [Some(0), Some(1), Some(2), None];

/// A mean of n values rounds n + 6 times, by 2⁻²⁴ of itself each, and its quotient of two sums 5 more;
/// the logarithm is off by 2⁻²¹ of 1 or three units in the last place of up to 4.
fn tolerance(side: u32, precision: Precision) -> Tolerance {
    let rounding = f32::EPSILON / 2.0;
    let absolute = (side * side + 11) as f32 * rounding + 8.0 * rounding + 24.0 * rounding;
    // A store rounds by 2⁻¹¹ of the value, and below 2⁻¹⁴ by 2⁻²⁴.
    match precision {
        Precision::F32 => Tolerance { absolute, relative: 0.0 },
        Precision::F16 => Tolerance { absolute: absolute + rounding, relative: 1.0 / 1024.0 },
    }
}

const FORMATS: [ImageFormat; 5] = [
    ImageFormat::Buffer(Element::F32),
    ImageFormat::Buffer(Element::F16),
    ImageFormat::Texture(Texture::Rgba16Float),
    ImageFormat::Texture(Texture::Rgba32Float),
    ImageFormat::Texture(Texture::Rgba8Unorm),
];

#[test]
fn contrast_equals_the_reference_in_every_format_with_bad_pixels() {
    let size = [37, 23];
    let cases = FORMATS.iter().flat_map(|format| PRECISIONS.map(|p| (*format, p)));
    run_cases(cases, |&(format, precision)| {
        let mut pixels = pixels(&mut Random::new(3), size);
        if !matches!(format, ImageFormat::Texture(Texture::Rgba8Unorm)) {
            pixels[200][1] = f32::NAN;
            pixels[300] = [0.5, 0.5, f32::INFINITY, 1.0];
            pixels[400] = [6e4, -5.0, 0.5, 1.0];
        }
        let albedo = cpu_image(&quantized(&pixels, format), size);
        let image = GpuImage::new(&pixels, size, format, Layout::packed(size[0]));
        compare(&run(&image, size, precision, 8), &expected(&albedo, 8), tolerance(8, precision))
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn contrast_equals_the_reference_at_any_size(
        size in [1_u32..60, 1_u32..60],
        side in sample::select(vec![2_u32, 4, 8]),
        precision in sample::select(PRECISIONS.to_vec()),
        seed in any::<u64>(),
    ) {
        let pixels = pixels(&mut Random::new(seed), size);
        let found = run(&packed(&pixels, size), size, precision, side);
        let expected = expected(&cpu_image(&pixels, size), side);
        compare(&found, &expected, tolerance(side, precision)).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn what_is_constant_has_exactly_no_contrast(
        size in [1_u32..40, 1_u32..40],
        color in [-0.5_f32..1.5, 0.0_f32..1.0, 0.0_f32..1e-3],
        side in sample::select(vec![2_u32, 4, 8]),
    ) {
        let [r, g, b] = color;
        let pixels = vec![[r, g, b, 1.0]; (size[0] * size[1]) as usize];
        let found = run(&packed(&pixels, size), size, Precision::F32, side);
        prop_assert!(found.data.iter().all(|&v| v == 0.0), "{color:?}");
    }
}

/// Inside the tile's edges, which repeat, a tile has the bits of the whole image.
#[test]
fn a_tile_has_the_contrast_of_the_whole_image() {
    let size = [70, 50];
    let pixels = pixels(&mut Random::new(9), size);
    let image = packed(&pixels, size);
    for precision in PRECISIONS {
        let whole = run(&image, size, precision, 8);
        let tile = Tile { origin: [16, 16], ..tile(size, Layout::packed(70)) };
        let part = run_tile(&image, &tile, [48, 32], precision, 8);
        let inner = |tensor: &Tensor, [left, top]: [usize; 2]| {
            Tensor::from_fn(3, 32 - 16, 48 - 16, |c, y, x| tensor.at(c, top + y, left + x))
        };
        assert_eq!(inner(&part, [8, 8]).data, inner(&whole, [24, 24]).data, "{precision:?}");
    }
}

fn packed(pixels: &[Pixel], size: [u32; 2]) -> GpuImage {
    GpuImage::new(pixels, size, ImageFormat::F32, Layout::packed(size[0]))
}

/// A texture of noise and black, and a square without.
fn pixels(random: &mut Random, [width, height]: [u32; 2]) -> Vec<Pixel> {
    let mut pixel = |i: u32| {
        let value = [0; 3].map(|_| random.value().abs());
        let [r, g, b] = match [i % width, i / width] {
            [8..24, 0..16] => [0.25, 0.5, 1.0],
            [x, _] if x % 5 == 0 => [0.0; 3],
            _ => value,
        };
        [r, g, b, 1.0]
    };
    (0..width * height).map(&mut pixel).collect()
}

fn expected(albedo: &Image, side: u32) -> Tensor {
    let input = reference::input_process(albedo, Some(albedo), None, 1.0, 16);
    let albedo = Tensor::from_fn(3, input.height, input.width, |c, y, x| input.at(3 + c, y, x));
    reference::contrast(&albedo, side as usize)
}

fn tile(size: [u32; 2], albedo: Layout) -> Tile {
    Tile { image_size: size, albedo, ..Tile::default() }
}

fn run(image: &GpuImage, size: [u32; 2], precision: Precision, side: u32) -> Tensor {
    let padded = size.map(|side| side.next_multiple_of(16));
    run_tile(image, &tile(size, Layout::packed(size[0])), padded, precision, side)
}

fn run_tile(
    image: &GpuImage,
    tile: &Tile,
    size: [u32; 2],
    precision: Precision,
    side: u32,
) -> Tensor {
    let context = context(precision);
    let (image, tiles) = (image.as_pass(), buffer(context, bytemuck::bytes_of(tile)));
    let view = view(&image);
    let (contrast, calls) = contrast(context, &tiles, binding(&image, view.as_ref()), size, side);
    submit(context, |pass| calls.iter().for_each(|call| call.record_at(pass, 0)));
    download(context, &contrast.tensor, &ChannelMap::from(MAP))
}
