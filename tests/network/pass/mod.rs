//! A pass recorded into the caller's encoder, over the caller's textures and buffers.

mod blend;
mod formats;
mod in_place;
mod layers;
mod motion;
mod motion_layers;
mod refusals;
mod warm_up;

use wgdenoise::{
    Denoiser, Element, Frame, Image, ImageFormat, InputScale, Inputs, Layout, NormalEncoding,
    Options, Pass, PassDescriptor,
};

use crate::support::{denoiser, frame, images, run, same_bits};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image};
use wgdenoise_testing::run_cases;

/// 32-bit floats in a buffer.
const F32: ImageFormat = ImageFormat::Buffer(Element::F32);

/// The images of a pass, on the GPU.
struct Scene {
    size: [u32; 2],
    color: GpuImage,
    albedo: Option<GpuImage>,
    normal: Option<GpuImage>,
    normal_encoding: NormalEncoding,
    output: GpuImage,
}

impl Scene {
    /// A frame with all images in one format, and a zeroed output in the same.
    fn new(frame: &Frame<'_>, format: ImageFormat, layout: Layout) -> Self {
        let (width, height) = frame.color.size();
        let size = [width, height];
        let image = |image: &Image| GpuImage::new(&opaque(image), size, format, layout);
        Self {
            size,
            color: image(frame.color),
            albedo: frame.albedo.map(image),
            normal: frame.normal.map(image),
            normal_encoding: NormalEncoding::Signed,
            output: GpuImage::new(&vec![[0.0; 4]; (width * height) as usize], size, format, layout),
        }
    }

    fn descriptor(&self) -> PassDescriptor<'_> {
        let [width, height] = self.size;
        PassDescriptor::new(width, height, self.color.as_pass(), self.output.as_pass())
            .albedo(self.albedo.as_ref().map(GpuImage::as_pass))
            .normal(self.normal.as_ref().map(GpuImage::as_pass))
            .normal_encoding(self.normal_encoding)
    }

    /// Runs the pass and returns the output.
    fn run(&self, denoiser: &Denoiser) -> Vec<Pixel> {
        let pass = denoiser.pass(&self.descriptor()).expect("the images fit");
        self.output.read(|encoder| pass.encode(encoder))
    }
}

fn opaque(image: &Image) -> Vec<Pixel> {
    image.pixels().iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect()
}

#[test]
fn a_pass_in_the_callers_encoder_makes_the_same_bits_as_the_blocking_call() {
    let images = images(90, 70);
    let layouts = [Layout::packed(90), Layout::new(5, 371, 4)];
    let scales = [None, Some(0.7)];
    let tiles = [None, Some(80)];
    let sets = [Inputs::ALL, Inputs { albedo: false, normal: true }];
    let mut cases = Vec::new();
    for (layout, scale) in layouts.iter().flat_map(|&l| scales.map(|s| (l, s))) {
        cases.extend(tiles.iter().flat_map(|&t| sets.map(|set| (layout, scale, t, set))));
    }
    run_cases(cases, |&(layout, input_scale, tile, inputs)| {
        let frame = frame(&images, inputs).input_scale(input_scale);
        let scene = Scene::new(&frame, F32, layout);
        let scale = input_scale.map_or(InputScale::Auto, InputScale::Value);
        let descriptor = scene.descriptor().input_scale(scale);
        let denoiser = denoiser(&Options::default().tile(tile));
        let pass = denoiser.pass(&descriptor).expect("the images fit");
        let found = cpu_image(&scene.output.read(|encoder| pass.encode(encoder)), scene.size);
        same_bits(&found, &run(&Options::default(), &frame))
    });
}

#[test]
fn inputs_that_the_weights_do_not_know_are_not_read() {
    let images = images(40, 30);
    let weights = crate::support::tiny().for_inputs(Inputs::default()).expect("color is known");
    let gpu = wgdenoise_testing::gpu::gpu();
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default()).unwrap();
    let [all, color] = [Inputs::ALL, Inputs::default()]
        .map(|inputs| Scene::new(&frame(&images, inputs), F32, Layout::packed(40)).run(&denoiser));
    same_bits(&cpu_image(&all, [40, 30]), &cpu_image(&color, [40, 30])).unwrap();
}

#[test]
fn networks_of_open_image_denoise_make_the_same_bits_in_a_pass() {
    let images = images(250, 70);
    let gpu = wgdenoise_testing::gpu::gpu();
    let names = ["rt_hdr", "rt_ldr", "rt_nrm", "rtlightmap_hdr"];
    let cases = names.iter().flat_map(|&name| [None, Some(240)].map(|tile| (name, tile)));
    run_cases(cases, |&(name, tile)| {
        let weights = crate::oidn::color_network(name);
        let frame = frame(&images, Inputs::default());
        let options = Options::default().tile(tile);
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options);
        let denoiser = denoiser.map_err(|e| e.to_string())?;
        let expected = denoiser.denoise(&frame).map_err(|e| e.to_string())?;
        let found = Scene::new(&frame, F32, Layout::packed(250)).run(&denoiser);
        same_bits(&cpu_image(&found, [250, 70]), &expected)
    });
}

#[test]
fn denoisers_and_passes_can_go_to_another_thread() {
    fn can<T: Send + Sync>() {}
    can::<Denoiser>();
    can::<Pass>();
}
