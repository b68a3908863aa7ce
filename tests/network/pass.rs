//! Recorded into a caller's encoder, on a caller's buffers.

use wgdenoise::{
    Denoiser, Frame, Image, Inputs, Layout, Options, Pass, PassDescriptor, PassImage, Precision,
    wgpu,
};

use crate::common::gpu::{buffer, context, read_back};
use crate::common::run_cases;
use crate::support::{denoiser, frame, images, run, same_bits};

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
        let frame = Frame { input_scale, ..frame(&images, inputs) };
        let found = run_pass(&denoiser(&Options { tile, ..Options::default() }), &frame, layout);
        same_bits(&found, &run(&Options::default(), &frame))
    });
}

/// A frame through a pass whose images are laid out in this way.
fn run_pass(denoiser: &Denoiser, frame: &Frame<'_>, layout: Layout) -> Image {
    let (context, (width, height)) = (context(Precision::F32), frame.color.size());
    let at = |i: usize| {
        let (x, y) = (i as u32 % width, i as u32 / width);
        (layout.offset + y * layout.row_stride + x * layout.pixel_stride) as usize
    };
    let upload = |image: &Image| {
        let mut elements = vec![f32::NAN; layout.elements(width, height) as usize];
        for (i, pixel) in image.pixels().iter().enumerate() {
            elements[at(i)..at(i) + 3].copy_from_slice(pixel);
        }
        buffer(context, bytemuck::cast_slice(&elements))
    };
    let [color, output] = [frame.color; 2].map(upload);
    let [albedo, normal] = [frame.albedo, frame.normal].map(|image| image.map(upload));
    let image = |buffer| PassImage::Buffer { buffer, layout };
    let descriptor = PassDescriptor {
        width,
        height,
        color: image(&color),
        albedo: albedo.as_ref().map(image),
        normal: normal.as_ref().map(image),
        output: image(&output),
        input_scale: frame.input_scale,
    };
    let pass = denoiser.pass(&descriptor).expect("the images fit");
    let bytes = read_back(context, output.size(), |encoder, target| {
        pass.encode(encoder);
        encoder.copy_buffer_to_buffer(&output, 0, target, 0, output.size());
    });
    let elements: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
    let pixel = |i: usize| [elements[at(i)], elements[at(i) + 1], elements[at(i) + 2]];
    let pixels = (0..(width * height) as usize).map(pixel).collect();
    Image::new(width, height, pixels).expect("the count is right")
}

#[test]
fn a_pass_refuses_images_that_do_not_fit() {
    let (context, denoiser) = (context(Precision::F32), denoiser(&Options::default()));
    let (enough, short) = (buffer(context, &[0; 192]), buffer(context, &[0; 188]));
    let other = buffer(context, &[0; 192]);
    let unusable = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 192,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let refuse = |color, output, width, expected: &str| {
        let image = |buffer| PassImage::Buffer { buffer, layout: Layout::packed(4) };
        let error = denoiser.pass(&PassDescriptor {
            width,
            height: 4,
            color: image(color),
            albedo: None,
            normal: None,
            output: image(output),
            input_scale: None,
        });
        let message = error.expect_err("it should be refused").to_string();
        assert!(message.contains(expected), "{message}");
    };
    refuse(&short, &enough, 4, "color of 4×4 pixels needs a buffer of 192 bytes, found 188");
    refuse(&enough, &short, 4, "output of 4×4 pixels");
    refuse(&unusable, &enough, 4, "STORAGE");
    refuse(&other, &other, 4, "same buffer");
    refuse(&other, &enough, 0, "at least 1");
    refuse(&other, &enough, 70_000, "at most 65536");
    refuse(&other, &enough, 5, "overlap");
}

#[test]
fn denoisers_and_passes_can_go_to_another_thread() {
    fn can<T: Send + Sync>() {}
    can::<Denoiser>();
    can::<Pass>();
}
