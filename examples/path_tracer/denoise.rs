//! The denoiser in the renderer: bound to a film once, recorded after it in every frame.

use wgdenoise::{Denoiser, Layout, Options, Pass, PassDescriptor, PassImage, Quality, Weights};

use crate::renderer::Result;
use crate::renderer::film::Film;

/// A film's denoised image.
pub(crate) struct Denoised {
    pass: Pass,
    /// Linear colour, `rgba32float`; alpha is undefined.
    pub(crate) output: wgpu::Texture,
    noisy: wgpu::Buffer,
    clean: wgpu::Buffer,
}

/// The denoiser for all films, on the renderer's own device.
pub(crate) fn denoiser(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    quality: Quality,
) -> Result<Denoiser> {
    Ok(Denoiser::new(device, queue, &Weights::builtin(quality)?, &Options::default())?)
}

impl Denoised {
    /// Binds a film. Another size is another film.
    pub(crate) fn new(denoiser: &Denoiser, device: &wgpu::Device, film: &Film) -> Result<Self> {
        let [width, height] = film.size;
        let row = row_bytes(width);
        let buffer = || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: u64::from(row) * u64::from(height),
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let (noisy, clean) = (buffer(), buffer());
        let layout = Layout::new(0, row / 4, 4);
        let pass = denoiser.pass(&PassDescriptor {
            width,
            height,
            color: PassImage::Buffer { buffer: &noisy, layout },
            albedo: None,
            normal: None,
            output: PassImage::Buffer { buffer: &clean, layout },
            input_scale: None,
        })?;
        let output = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("denoised"),
            size: film.color.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Ok(Self { pass, output, noisy, clean })
    }

    /// Records the denoising of what the film holds by then.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder, film: &Film) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes(film.size[0])),
            rows_per_image: None,
        };
        let side = |buffer| wgpu::TexelCopyBufferInfo { buffer, layout };
        let size = film.color.size();
        encoder.copy_texture_to_buffer(film.color.as_image_copy(), side(&self.noisy), size);
        self.pass.encode(encoder);
        encoder.copy_buffer_to_texture(side(&self.clean), self.output.as_image_copy(), size);
    }
}

fn row_bytes(width: u32) -> u32 {
    (width * 16).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
