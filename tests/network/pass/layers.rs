//! Further layers of an image in a pass.

use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{
    Denoiser, Element, Frame, Image, ImageFormat, Inputs, Layout, Options, PassLayer, Precision,
};

use super::{F32, Scene, opaque};
use crate::support::{
    denoiser, denoiser_of, frame, images, same_bits, tiny_demodulation, tiny_kernels,
};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image};
use wgdenoise_testing::run_cases;

const SIZE: [u32; 2] = [90, 70];

/// An image and two of its layers, rounded to a format.
struct Picture {
    images: [Image; 3],
    layers: [Image; 2],
}

impl Picture {
    fn new() -> Self {
        let all = images(SIZE[0], SIZE[1]);
        let half = |image: &Image, factor: f32| {
            let pixels = image.pixels().iter().map(|p| p.map(|v| v * factor)).collect();
            Image::new(SIZE[0], SIZE[1], pixels).expect("the size is the same")
        };
        let layers = [half(&all[0], 0.25), half(&all[2], 3.0)];
        Self { images: all, layers }
    }

    fn expected(&self, options: &Options) -> [Image; 3] {
        let layers = [&self.layers[0], &self.layers[1]];
        let frame = frame(&self.images, Inputs::ALL).layers(&layers);
        let found = denoiser_of(&tiny_kernels(), options).denoise_layers(&frame, &mut |_| {});
        let found = found.expect("the frame is fine");
        let [first, second] = found.layers.try_into().expect("there are two");
        [found.color, first, second]
    }
}

fn on_gpu(image: &Image, (format, layout): (ImageFormat, Layout)) -> GpuImage {
    GpuImage::new(&opaque(image), SIZE, format, layout)
}

fn empty(format: (ImageFormat, Layout)) -> GpuImage {
    on_gpu(&Image::filled(SIZE[0], SIZE[1], [0.0; 3]).expect("a valid image"), format)
}

/// Each layer and its output have their own format and layout.
#[test]
fn layers_in_a_pass_have_the_bits_of_the_blocking_call() {
    let picture = Picture::new();
    let float = (ImageFormat::Texture(Texture::Rgba32Float), Layout::default());
    let gaps = (F32, Layout::new(7, 380, 4));
    let packed = (F32, Layout::packed(90));
    // The color's is first: its position in a buffer matters to the layers too.
    let cases = [[float, packed, float, gaps, packed], [gaps, packed, gaps, float, float]];
    run_cases(cases.into_iter().flat_map(|case| [None, Some(80)].map(|t| (case, t))), |case| {
        let &([color, noisy0, output0, noisy1, output1], tile) = case;
        let options = Options::default().tile(tile);
        let denoiser = denoiser_of(&tiny_kernels(), &options);
        let scene = Scene::new(&frame(&picture.images, Inputs::ALL), color.0, color.1);
        let noisy = [on_gpu(&picture.layers[0], noisy0), on_gpu(&picture.layers[1], noisy1)];
        let outputs = [empty(output0), empty(output1)];
        let layers = [0, 1].map(|i| PassLayer::new(noisy[i].as_pass(), outputs[i].as_pass()));
        let pass = denoiser.pass(&scene.descriptor().layers(&layers)).expect("the images fit");
        let found = scene.output.read(|encoder| pass.encode(encoder));
        let [expected, first, second] = picture.expected(&Options::default());
        same_bits(&cpu_image(&found, SIZE), &expected)?;
        for (output, expected) in outputs.iter().zip([first, second]) {
            same_bits(&cpu_image(&output.read(|_| {}), SIZE), &expected)?;
        }
        Ok(())
    });
}

/// Layers and color in every format; 16-bit ones round.
#[test]
fn layers_of_16_bits_come_back_within_their_rounding() {
    let picture = Picture::new();
    let half = [
        (ImageFormat::Texture(Texture::Rgba16Float), Layout::default()),
        (ImageFormat::Buffer(Element::F16), Layout::packed(90)),
    ];
    let options = Options::default().precision(Precision::F32);
    let [_, first, _] = picture.expected(&options);
    let denoiser = denoiser_of(&tiny_kernels(), &options);
    run_cases(half, |&format| {
        let scene = Scene::new(&frame(&picture.images, Inputs::ALL), format.0, format.1);
        let (noisy, output) = (on_gpu(&picture.layers[0], format), empty(format));
        let layers = [PassLayer::new(noisy.as_pass(), output.as_pass())];
        let pass = denoiser.pass(&scene.descriptor().layers(&layers)).expect("the images fit");
        let found = cpu_image(&output.read(|encoder| pass.encode(encoder)), SIZE);
        let values = |image: &Image| image.pixels().as_flattened().to_vec();
        let off = values(&found).into_iter().zip(values(&first));
        // Inputs and weights are rounded too, by 2⁻¹¹ each.
        let off = off.map(|(found, expected)| (found - expected).abs() / expected.abs().max(0.1));
        let most = off.fold(0.0_f32, f32::max);
        if most < 1e-2 { Ok(()) } else { Err(format!("off by {most}")) }
    });
}

#[test]
fn outputs_may_be_the_layer_itself_or_an_image_that_a_later_layer_needs() {
    let picture = Picture::new();
    let format = (ImageFormat::Texture(Texture::Rgba32Float), Layout::default());
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(80));
    let scene = Scene::new(&frame(&picture.images, Inputs::ALL), format.0, format.1);
    let noisy = [on_gpu(&picture.layers[0], format), on_gpu(&picture.layers[1], format)];
    // The first layer overwrites the color, and the second overwrites the first.
    let outputs = [scene.color.as_pass(), noisy[0].as_pass()];
    let layers = [0, 1].map(|i| PassLayer::new(noisy[i].as_pass(), outputs[i]));
    let descriptor = scene.descriptor().output(noisy[1].as_pass()).layers(&layers);
    let pass = denoiser.pass(&descriptor).expect("the images fit");
    let first = scene.color.read(|encoder| pass.encode(encoder));
    let found = [noisy[1].read(|_| {}), first, noisy[0].read(|_| {})];
    for (found, expected) in found.iter().zip(picture.expected(&Options::default())) {
        same_bits(&cpu_image(found, SIZE), &expected).unwrap();
    }
}

#[test]
fn alpha_of_a_layer_and_the_share_of_noisy_color_are_the_layers_own() {
    let picture = Picture::new();
    let format = (F32, Layout::packed_rgba(90));
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default());
    let scene = Scene::new(&frame(&picture.images, Inputs::ALL), F32, Layout::packed(90));
    let with_alpha = |&[r, g, b]: &[f32; 3]| [r, g, b, 0.25];
    let pixels: Vec<Pixel> = picture.layers[0].pixels().iter().map(with_alpha).collect();
    let (noisy, output) = (GpuImage::new(&pixels, SIZE, format.0, format.1), empty(format));
    let layers = [PassLayer::new(noisy.as_pass(), output.as_pass())];
    let pass = denoiser.pass(&scene.descriptor().layers(&layers)).expect("the images fit");
    pass.set_blend(1.0);
    let found = output.read(|encoder| pass.encode(encoder));
    assert_eq!(found, pixels);
}

/// Light is demodulated as in the blocking call; other layers are treated like alpha.
#[test]
fn layers_of_a_demodulating_pass_are_light_or_not() {
    let picture = Picture::new();
    let weights = tiny_demodulation();
    let denoiser = denoiser_of(&weights, &Options::default().tile(112));
    let light = [&picture.layers[0]];
    let alpha: Vec<_> = picture.layers[0].pixels().iter().map(|pixel| pixel[0]).collect();
    let blocking = frame(&picture.images, Inputs::ALL).layers(&light).alpha(alpha.as_slice());
    let expected = denoiser.denoise_layers(&blocking, &mut |_| {}).expect("the frame is fine");
    let gray = Image::new(SIZE[0], SIZE[1], alpha.iter().map(|&a| [a; 3]).collect());
    let gray = gray.expect("the count is right");
    for (color, albedo) in [(F32, F32), (ImageFormat::Texture(Texture::Rgba32Float), F32)] {
        let scene = Scene::new(&frame(&picture.images, Inputs::ALL), color, Layout::packed(90));
        let other = on_gpu(&picture.images[1], (albedo, Layout::new(3, 400, 4)));
        let format = (F32, Layout::packed(90));
        let noisy = [&picture.layers[0], &gray].map(|image| on_gpu(image, format));
        let outputs = [empty(format), empty(format)];
        let layers =
            [0, 1].map(|i| PassLayer::new(noisy[i].as_pass(), outputs[i].as_pass()).light(i == 0));
        let descriptor = scene.descriptor().albedo(other.as_pass()).layers(&layers);
        let pass = denoiser.pass(&descriptor).expect("the images fit");
        let found = scene.output.read(|encoder| pass.encode(encoder));
        let [first, second] = outputs.map(|output| cpu_image(&output.read(|_| {}), SIZE));
        same_bits(&cpu_image(&found, SIZE), &expected.color).unwrap();
        same_bits(&first, &expected.layers[0]).unwrap();
        let found: Vec<_> = second.pixels().iter().map(|pixel| pixel[0]).collect();
        assert_eq!(Some(found), expected.alpha);
    }
}

#[test]
fn what_no_layer_can_be_is_refused() {
    let picture = Picture::new();
    let format = (ImageFormat::Texture(Texture::Rgba32Float), Layout::default());
    let scene = Scene::new(&Frame::new(&picture.images[0]), format.0, format.1);
    let (noisy, output) = (on_gpu(&picture.layers[0], format), empty(format));
    let error = |denoiser: &Denoiser, layers: &[PassLayer<'_>]| {
        denoiser.pass(&scene.descriptor().layers(layers)).unwrap_err().to_string()
    };
    let pyramid = denoiser_of(&tiny_kernels(), &Options::default());
    let layer = PassLayer::new(noisy.as_pass(), output.as_pass());
    let text = error(&denoiser(&Options::default()), &[layer]);
    assert!(text.contains("predict color and not a kernel pyramid"), "{text}");
    let text = error(&pyramid, &[layer, layer]);
    assert!(text.contains("output of layer 0 and output of layer 1 are the same"), "{text}");
    let text = error(&pyramid, &[PassLayer::new(noisy.as_pass(), scene.output.as_pass())]);
    assert!(text.contains("output and output of layer 0 are the same texture"), "{text}");
    let small = GpuImage::new(&[[0.0; 4]; 90], [90, 1], F32, Layout::packed(90));
    let text = error(&pyramid, &[layer, PassLayer::new(small.as_pass(), output.as_pass())]);
    assert!(text.contains("layer 1 of 90×70 pixels needs a buffer of"), "{text}");
}
