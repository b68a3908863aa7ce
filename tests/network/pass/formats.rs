//! All formats of all images, mixed.

use wgdenoise::internals::reference;
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{
    Element, Image, ImageFormat, InputScale, Inputs, KernelSet, Layout, NormalEncoding, Options,
    Precision,
};

use super::{F32, Scene};
use crate::support::{HALF, denoiser, encoded, frame, images, run, same_bits};
use wgdenoise_testing::gpu::kernel_sets;
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Tolerance, compare, run_cases};

const SIZE: [u32; 2] = [45, 31];
const F16: ImageFormat = ImageFormat::Buffer(Element::F16);

/// A format, the pixel layout for buffers, and the encoding of normals.
type Stored = (ImageFormat, Layout, NormalEncoding);

fn texture(format: Texture) -> Stored {
    (ImageFormat::Texture(format), Layout::default(), NormalEncoding::Signed)
}

fn unorm(format: ImageFormat) -> Stored {
    (format, Layout::packed(SIZE[0]), NormalEncoding::Unorm)
}

fn buffer(format: ImageFormat, layout: Layout) -> Stored {
    (format, layout, NormalEncoding::Signed)
}

/// Images with alpha: textures, and buffers with odd strides in which neighbors share words.
fn floats() -> [Stored; 6] {
    [
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba32Float),
        buffer(F16, Layout::packed_rgba(SIZE[0])),
        buffer(F32, Layout::packed_rgba(SIZE[0])),
        buffer(F16, Layout::new(7, 317, 7).with_alpha()),
        buffer(F32, Layout::new(70, 317, 7).with_alpha()),
    ]
}

#[test]
fn every_format_gives_what_its_values_give_as_floats() {
    let albedos = [
        texture(Texture::Rgba8Unorm),
        texture(Texture::Rgba8UnormSrgb),
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba32Float),
        buffer(F16, Layout::packed(SIZE[0])),
        buffer(F32, Layout::new(3, 200, 4)),
    ];
    let normals = [
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba8Snorm),
        unorm(ImageFormat::Texture(Texture::Rgba8Unorm)),
        unorm(ImageFormat::Texture(Texture::Rgb10a2Unorm)),
        buffer(F16, Layout::packed(SIZE[0])),
        unorm(F32),
    ];
    // Uses every format of each image once, in combination with others of the other images.
    let images = |i| [floats()[i], albedos[i], normals[i], floats()[(i + 2) % 6]];
    let sets = kernel_sets(Precision::F32);
    let cases = sets.iter().flat_map(|&set| (0..6).map(move |i| (images(i), set)));
    run_cases(cases, |&(images, kernels)| check(images, kernels));
}

/// In the transfer domain, whose bright part is `log(v) / 16.3`. A 16-bit output rounds by 2⁻¹¹, or
/// a driver truncates by 2⁻¹⁰, which is 6e-5 there.
const TOLERANCE: Tolerance = Tolerance { absolute: 1e-4, relative: 0.0 };
/// Vulkan allows drivers to decode sRGB with an error of half an 8-bit step.
const SRGB: Tolerance = Tolerance { absolute: 2e-3, relative: 0.0 };

fn check([color, albedo, normal, output]: [Stored; 4], kernels: KernelSet) -> Result<(), String> {
    let images = images(SIZE[0], SIZE[1]);
    let [colors, albedos, normals] = [&images[0], &images[1], &images[2]].map(with_alpha);
    let encoded_normals =
        normals.iter().map(|n| n.map(|v| encode_normal(v, normal.2))).collect::<Vec<_>>();
    let image = |pixels: &[Pixel], stored: Stored| GpuImage::new(pixels, SIZE, stored.0, stored.1);
    let scene = Scene {
        size: SIZE,
        color: image(&colors, color),
        albedo: Some(image(&albedos, albedo)),
        normal: Some(image(&encoded_normals, normal)),
        normal_encoding: normal.2,
        output: image(&vec![[0.0; 4]; colors.len()], output),
    };
    let options = Options::default().kernels(kernels).precision(Precision::F32);
    let found = scene.run(&denoiser(&options));
    let colors = quantized(&colors, color.0);
    let normals = quantized(&encoded_normals, normal.0);
    let normals: Vec<_> = normals.iter().map(|n| n.map(|v| decode_normal(v, normal.2))).collect();
    let albedos = quantized(&albedos, albedo.0);
    let images = [&colors, &albedos, &normals].map(|pixels| cpu_image(pixels, SIZE));
    let expected = run(&options, &frame(&images, Inputs::ALL));
    let expected = held_by(&expected, output.0);
    let srgb = albedo.0 == ImageFormat::Texture(Texture::Rgba8UnormSrgb);
    let tolerance = match (srgb, kernels) {
        // With other inputs, 16-bit sums round differently, so the error is as large as against the
        // reference.
        (true, KernelSet::Half) => HALF,
        (true, _) => SRGB,
        (false, _) => TOLERANCE,
    };
    let [result, expected] = [cpu_image(&found, SIZE), expected].map(|image| encoded(&image, 1e-3));
    compare(&result, &expected, tolerance)?;
    let alpha = |pixels: &[Pixel]| pixels.iter().map(|p| p[3]).collect::<Vec<_>>();
    if alpha(&found) != alpha(&quantized(&colors, output.0)) {
        return Err("alpha was not carried over".into());
    }
    if scene.output.gaps_are_untouched() { Ok(()) } else { Err("a gap was written to".into()) }
}

/// Clamps an image to values that the format can store.
fn held_by(image: &Image, format: ImageFormat) -> Image {
    let half = [F16, ImageFormat::Texture(Texture::Rgba16Float)].contains(&format);
    let largest = if half { 65504.0 } else { f32::MAX };
    let mut image = image.clone();
    image.pixels_mut().iter_mut().flatten().for_each(|v| *v = v.min(largest));
    image
}

/// Adds an alpha that every float format stores exactly.
fn with_alpha(image: &Image) -> Vec<Pixel> {
    let alpha = |i: usize| (i % 9) as f32 / 8.0;
    image.pixels().iter().enumerate().map(|(i, &[r, g, b])| [r, g, b, alpha(i)]).collect()
}

fn encode_normal(value: f32, encoding: NormalEncoding) -> f32 {
    if encoding == NormalEncoding::Unorm { 0.5 * value + 0.5 } else { value }
}

fn decode_normal(value: f32, encoding: NormalEncoding) -> f32 {
    if encoding == NormalEncoding::Unorm { 2.0 * value - 1.0 } else { value }
}

/// NaN and ±∞ are filled, and a group of four +∞ becomes bright, in every format that can store
/// them.
#[test]
fn bad_pixels_are_repaired_in_every_format() {
    let mut pixels = with_alpha(&images(SIZE[0], SIZE[1])[0]);
    let values = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    // The eight neighbors' mean is exact in every format, and no division rounds.
    pixels[..45 * 5].fill([0.5, 2.0, 1.0, 1.0]);
    pixels[51][0] = 1.5;
    for (i, value) in values.into_iter().enumerate() {
        pixels[49 * i + 50][i] = value;
    }
    let sun = [20, 21, 65, 66].map(|i| i + 45 * 8);
    for i in sun {
        pixels[i][1] = f32::INFINITY;
    }
    let mut filled = pixels.clone();
    for i in sun {
        filled[i][1] = 65504.0;
    }
    let colors = filled.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    let color = Image::new(SIZE[0], SIZE[1], colors).expect("the count is right");
    for (pixel, [r, g, b]) in filled.iter_mut().zip(reference::fill(&color).color.pixels()) {
        *pixel = [*r, *g, *b, pixel[3]];
    }
    let denoiser = denoiser(&Options::default());
    run_cases(floats(), |&stored| {
        let result = |pixels: &[Pixel]| {
            let image = |pixels: &[Pixel]| GpuImage::new(pixels, SIZE, stored.0, stored.1);
            let (color, output) = (image(pixels), image(&vec![[0.0; 4]; pixels.len()]));
            let normal_encoding = NormalEncoding::Signed;
            let scene =
                Scene { size: SIZE, color, albedo: None, normal: None, normal_encoding, output };
            // A measured exposure would skip bad pixels but count their replacements.
            let input_scale = InputScale::Value(0.3);
            let descriptor = scene.descriptor().input_scale(input_scale);
            let pass = denoiser.pass(&descriptor).expect("the images fit");
            scene.output.read(|encoder| pass.encode(encoder))
        };
        let [found, expected] = [&pixels, &filled].map(|pixels| result(pixels));
        if found == expected { Ok(()) } else { Err("the result differs".into()) }
    });
}

/// A 16-bit output saturates: brighter values become its maximum, not infinity.
#[test]
fn what_is_too_bright_for_the_output_is_clamped() {
    let pixels = vec![[3e5, 1.0, 1e-3, 1.0]; 48];
    for format in [F16, ImageFormat::Texture(Texture::Rgba16Float)] {
        let scene = Scene {
            size: [8, 6],
            color: GpuImage::new(&pixels, [8, 6], F32, Layout::packed(8)),
            albedo: None,
            normal: None,
            normal_encoding: NormalEncoding::Signed,
            output: GpuImage::new(&pixels, [8, 6], format, Layout::packed(8)),
        };
        // A constant block is clean, so its color passes through unchanged.
        let [red, green, blue, alpha] = scene.run(&denoiser(&Options::default()))[20];
        assert_eq!([red, green], [65504.0, 1.0], "{format:?}");
        // The color has no alpha here, and an RGB buffer has no room for one.
        assert!(alpha == 1.0 || format == F16, "{format:?}: {alpha}");
        assert!((blue / 1e-3 - 1.0).abs() < 1.0 / 1024.0, "{format:?}: {blue}");
    }
}

/// All of these mean that there is no surface.
#[test]
fn no_normal_is_no_normal_in_both_encodings() {
    let mut images = images(SIZE[0], SIZE[1]);
    let inputs = Inputs { albedo: false, normal: true };
    images[2].pixels_mut().fill([0.0; 3]);
    let expected = run(&Options::default(), &frame(&images, inputs));
    let denoiser = denoiser(&Options::default());
    let cases =
        [(0.0, NormalEncoding::Signed), (0.0, NormalEncoding::Unorm), (0.5, NormalEncoding::Unorm)];
    run_cases(cases, |&(value, normal_encoding)| {
        let layout = Layout::packed(SIZE[0]);
        let normal = GpuImage::new(&vec![[value; 4]; 45 * 31], SIZE, F32, layout);
        let scene = Scene {
            normal: Some(normal),
            normal_encoding,
            ..Scene::new(&frame(&images, inputs), F32, layout)
        };
        same_bits(&cpu_image(&scene.run(&denoiser), SIZE), &expected)
    });
}
