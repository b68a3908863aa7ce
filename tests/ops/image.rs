//! Images in every format, as the first and the last kernel read and write them.

use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::Encoding;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::image::{Element, ImageBinding, ImageFormat};
use wgdenoise::internals::ops::input_process::{self, Sources, input_process};
use wgdenoise::internals::ops::output_process::{ResultImages, output_process};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{PassImage, Precision, wgpu};

use wgdenoise_testing::gpu::{buffer, context, download, submit, upload};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

const SIZE: [u32; 2] = [13, 7];

/// Odd strides, so that the pixels of 16-bit images share words.
fn formats() -> [(ImageFormat, Layout); 6] {
    [
        (ImageFormat::Buffer(Element::F32), Layout::packed(13)),
        (ImageFormat::Buffer(Element::F32), Layout::new(9, 70, 5).with_alpha()),
        (ImageFormat::Buffer(Element::F16), Layout::packed(13)),
        (ImageFormat::Buffer(Element::F16), Layout::new(9, 71, 5).with_alpha()),
        (ImageFormat::Texture(Texture::Rgba16Float), Layout::default()),
        (ImageFormat::Texture(Texture::Rgba32Float), Layout::default()),
    ]
}

fn pixels() -> Vec<Pixel> {
    let mut random = Random::new(7);
    let mut pixel = |i: u32| {
        let [r, g, b] = [0; 3].map(|_| (random.value() * 9.0).exp2());
        [r, g, b, (i % 5) as f32 / 4.0]
    };
    let mut pixels: Vec<_> = (0..SIZE[0] * SIZE[1]).map(&mut pixel).collect();
    // A subnormal 16-bit number, and non-finite values.
    pixels[20] = [3e-6, f32::NAN, f32::INFINITY, 0.5];
    pixels
}

/// The binding of a pass's image.
pub(crate) fn binding<'a>(
    image: &PassImage<'a>,
    view: Option<&'a wgpu::TextureView>,
) -> ImageBinding<'a> {
    match (*image, view) {
        (PassImage::Buffer { buffer, element, .. }, _) => {
            ImageBinding::Buffer { buffer, element, offset: 0, size: None }
        }
        (_, Some(view)) => ImageBinding::Texture(view),
        _ => unreachable!("a texture has a view"),
    }
}

pub(crate) fn view(image: &PassImage<'_>) -> Option<wgpu::TextureView> {
    match image {
        PassImage::Texture(texture) => Some(texture.create_view(&Default::default())),
        _ => None,
    }
}

/// As for `input_process`.
const READ: Tolerance = Tolerance { absolute: 2e-6, relative: 0.0 };

#[test]
fn every_format_is_read_as_its_definition_says() {
    let context = context(Precision::F32);
    run_cases(formats(), |&(format, layout)| {
        let image = GpuImage::new(&pixels(), SIZE, format, layout);
        let (pass_image, expected) = (image.as_pass(), quantized(&pixels(), format));
        let view = view(&pass_image);
        let tile = Tile { image_size: SIZE, color: layout, ..Tile::default() };
        let sources = Sources {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            color: binding(&pass_image, view.as_ref()),
            albedo: None,
            normal: None,
            unorm_normal: false,
            input_scale: &buffer(context, bytemuck::bytes_of(&0.5_f32)),
            encoding: Encoding::default(),
        };
        let output = GpuTensor::of(&GpuTensor::texture(context, [16, 16], 1), 0, 1);
        let call = input_process(context, &sources, &output);
        submit(context, |pass| call.record_at(pass, 0));
        let found = download(context, &output, &input_process::channel_map(3));
        let expected = reference::input_process(&cpu_image(&expected, SIZE), None, None, 0.5, 16);
        compare(&found, &expected, READ)
    });
}

/// As for `output_process`; 16-bit formats round by 2⁻¹¹, and drivers may truncate.
const STORED: Tolerance = Tolerance { absolute: 1e-7, relative: 1.0 / 1024.0 };

#[test]
fn every_format_is_written_with_the_blend_and_the_alpha_of_the_color() {
    let context = context(Precision::F32);
    let mut random = Random::new(8);
    let values = (0..3 * 256).map(|_| 0.4 + 0.2 * random.value()).collect();
    let tensor = Tensor::new(3, 16, 16, values);
    let noisy = GpuImage::new(
        &pixels(),
        SIZE,
        ImageFormat::Texture(Texture::Rgba32Float),
        Layout::default(),
    );
    let denoised = reference::output_process(&tensor, 0.5, SIZE[0], SIZE[1]);
    run_cases(formats(), |&(format, layout)| {
        let share = 0.25_f32;
        let output = GpuImage::new(&[[-1.5; 4]; 91], SIZE, format, layout);
        let images = [noisy.as_pass(), output.as_pass()];
        let views = images.each_ref().map(view);
        let tile = Tile { image_size: SIZE, end: SIZE, output: layout, ..Tile::default() };
        let images = ResultImages {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            input_scale: &buffer(context, bytemuck::bytes_of(&0.5_f32)),
            color: binding(&images[0], views[0].as_ref()),
            output: binding(&images[1], views[1].as_ref()),
            blend: &buffer(context, bytemuck::bytes_of(&share)),
            encoding: Encoding::default(),
        };
        let call = output_process(context, &upload(context, &tensor, &channel_map(3)), &images);
        submit(context, |pass| call.record_at(pass, 0));
        let found = output.read(|_| {});
        let mut expected = denoised.clone();
        for (pixel, noisy) in expected.pixels_mut().iter_mut().zip(pixels()) {
            *pixel = [0, 1, 2].map(|c| wgdenoise_testing::pixels::blend(pixel[c], noisy[c], share));
        }
        let colors = [cpu_image(&found, SIZE), expected].map(|image| image_tensor(&image));
        compare(&colors[0], &colors[1], STORED)?;
        let has_alpha = matches!(format, ImageFormat::Texture(_)) || layout.channels() == 4;
        if has_alpha && found.iter().zip(pixels()).any(|(found, noisy)| found[3] != noisy[3]) {
            return Err("alpha was not carried over".into());
        }
        if output.gaps_are_untouched() { Ok(()) } else { Err("a gap was written to".into()) }
    });
}
