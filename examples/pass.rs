//! A denoising pass in a renderer's command encoder: `cargo run --release --example pass`.

use wgdenoise::wgpu::util::{BufferInitDescriptor, DeviceExt as _, TextureDataOrder};
use wgdenoise::wgpu::{self, BufferUsages, TextureUsages};
use wgdenoise::{Denoiser, Options, PassDescriptor, PassImage, Quality, Weights};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Once: the renderer's device. These optional features and limits make the denoiser faster.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wgdenoise::required_features(&adapter),
        required_limits: wgdenoise::required_limits(&adapter),
        ..Default::default()
    }))?;
    let weights = Weights::builtin(Quality::Fast)?;
    let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default())?;

    // Per size: the renderer's textures, here random light on a gray surface.
    let input = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 64, height: 48, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
    let clean = device.create_texture(&wgpu::TextureDescriptor { usage, ..input.clone() });
    let upload = |pixels: &[[f32; 4]]| {
        let bytes = bytemuck::cast_slice(pixels);
        device.create_texture_with_data(&queue, &input, TextureDataOrder::LayerMajor, bytes)
    };
    let noise = (0..64 * 48).map(|i| 0.25 + (43758.547 * (i as f32).sin()).rem_euclid(0.5));
    let noisy = upload(&noise.map(|value| [value, value, value, 1.0]).collect::<Vec<_>>());
    let albedo = upload(&vec![[0.5; 4]; 64 * 48]);
    let [color, albedo, output] = [&noisy, &albedo, &clean].map(PassImage::Texture);
    let pass = denoiser.pass(&PassDescriptor::new(64, 48, color, output).albedo(albedo))?;

    // Per frame: encoded and submitted together with the renderer's own passes.
    let mut encoder = device.create_command_encoder(&Default::default());
    pass.encode(&mut encoder);
    let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
    let zeros = BufferInitDescriptor { label: None, contents: &[0; 16], usage };
    let buffer = device.create_buffer_init(&zeros);
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout: Default::default() };
    let origin = wgpu::Origin3d { x: 32, y: 24, z: 0 };
    let source = wgpu::TexelCopyTextureInfo { origin, ..clean.as_image_copy() };
    encoder.copy_texture_to_buffer(source, target, Default::default());
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let pixel: [f32; 4] = bytemuck::pod_read_unaligned(&buffer.get_mapped_range(..)?);
    println!("middle pixel: {pixel:?}");
    assert!(pixel[..3].iter().all(|value| (value - 0.5).abs() < 0.1), "the noise is gone");
    Ok(())
}
