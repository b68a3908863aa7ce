//! Times a frame whose images stay on the GPU, as in a renderer.

use std::time::Instant;

use wgdenoise::measure::{repeat, test_card};
use wgdenoise::wgpu::{self, util::DeviceExt as _};
use wgdenoise::{Denoiser, Element, Gpu, Image, Layout, PassDescriptor, PassImage, Result};

/// Returns the seconds to record the pass, submit it and wait, for `runs` runs after a warm-up,
/// shortest first. With motion, every frame is averaged with the last ones, half a pixel away, by
/// light, albedo, normal and depth.
pub(crate) fn measure(
    gpu: &Gpu,
    denoiser: &Denoiser,
    [width, height]: [u32; 2],
    moves: bool,
    runs: u32,
) -> Result<Vec<f64>> {
    let [color, albedo, normal] = test_card(width, height)?.map(|image| upload(gpu, &image));
    let output = upload(gpu, &Image::filled(width, height, [0.0; 3])?);
    let motion = upload(gpu, &Image::filled(width, height, [0.5; 3])?);
    let layout = Layout::packed(width);
    let image = |buffer| PassImage::Buffer { buffer, element: Element::F32, layout };
    let pass = denoiser.pass(
        &PassDescriptor::new(width, height, image(&color), image(&output))
            .albedo(image(&albedo))
            .normal(image(&normal))
            .motion(moves.then_some(image(&motion)))
            .depth(moves.then_some(image(&motion))),
    )?;
    repeat(runs, || {
        let begin = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        pass.encode(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device works");
        Ok(begin.elapsed().as_secs_f64())
    })
}

fn upload(gpu: &Gpu, image: &Image) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(image.pixels()),
        usage: wgpu::BufferUsages::STORAGE,
    })
}
