//! Images as textures: linear light in 32-bit float, with mip levels for small zooms.

use wgdenoise::{Image, Rect, wgpu};
use wgpu::util::DeviceExt as _;

use crate::gpu::host::Gpu;
use crate::gpu::levels::Pixels;

/// Maximum bytes per upload buffer.
const BAND_BYTES: usize = 32 << 20;

/// An image on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    view: wgpu::TextureView,
}

impl Texture {
    pub(crate) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Creates a black image of this width and height. May be called from any thread.
    ///
    /// # Errors
    /// If the device does not allow an image this large, or is out of memory.
    pub(crate) fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self, String> {
        let most = gpu.device.limits().max_texture_dimension_2d;
        if width.max(height) > most {
            return Err(format!(
                "an image of {width}×{height} pixels cannot be shown: the adapter shows at most \
                 {most} pixels a side"
            ));
        }
        guarded(gpu, [width, height], || {
            let texture = create(&gpu.device, [width, height]);
            Self { view: texture.create_view(&Default::default()) }
        })
    }

    /// Uploads an image.
    ///
    /// # Errors
    /// Same as [`new`](Self::new).
    pub(crate) fn upload(gpu: &Gpu, image: &Image) -> Result<Self, String> {
        let (width, height) = image.size();
        let texture = Self::new(gpu, [width, height])?;
        let rows = (BAND_BYTES / size_of::<[f32; 3]>() / width as usize).max(1);
        guarded(gpu, [width, height], || {
            for (i, band) in image.pixels().chunks(rows * width as usize).enumerate() {
                let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some("band"),
                    contents: bytemuck::cast_slice(band),
                    usage: wgpu::BufferUsages::STORAGE,
                });
                let top = (i * rows) as u32;
                let end = [width, (top + rows as u32).min(height)];
                let rect = Rect { begin: [0, top], end };
                texture.place(gpu, &Pixels { buffer: &buffer, first: 0, stride: width, rect });
            }
            texture.finish(gpu);
        })?;
        Ok(texture)
    }

    /// Fills part of the image.
    pub(crate) fn place(&self, gpu: &Gpu, pixels: &Pixels<'_>) {
        gpu.levels().place(pixels, &self.level(0));
    }

    /// Fills the mip levels.
    pub(crate) fn finish(&self, gpu: &Gpu) {
        let texture = self.view.texture();
        for level in 1..texture.mip_level_count() {
            let size = [texture.width(), texture.height()].map(|side| (side >> level).max(1));
            gpu.levels().halve([&self.level(level - 1), &self.level(level)], size);
        }
    }

    /// The texels of a level.
    #[cfg(test)]
    pub(crate) fn read(&self, gpu: &Gpu, level: u32) -> Vec<[f32; 4]> {
        let texture = self.view.texture();
        let [width, height] =
            [texture.width(), texture.height()].map(|side| (side >> level).max(1));
        let row = width.next_multiple_of(16) * 16;
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let from = wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(row), ..Default::default() };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        encoder.copy_texture_to_buffer(from, to, size);
        gpu.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = buffer.slice(..).get_mapped_range().unwrap();
        let rows = bytes.chunks(row as usize).map(|row| &row[..width as usize * 16]);
        rows.flat_map(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>).collect()
    }

    fn level(&self, level: u32) -> wgpu::TextureView {
        self.view.texture().create_view(&wgpu::TextureViewDescriptor {
            base_mip_level: level,
            mip_level_count: Some(1),
            ..Default::default()
        })
    }
}

/// Runs `act`, which allocates GPU memory for an image of this size; an out-of-memory error becomes
/// a sentence.
fn guarded<T>(gpu: &Gpu, [width, height]: [u32; 2], act: impl FnOnce() -> T) -> Result<T, String> {
    let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let done = act();
    match pollster::block_on(memory.pop()) {
        None => Ok(done),
        Some(_) => Err(format!(
            "the adapter has no memory to show an image of {width}×{height} pixels; close other \
             programs or open a smaller image"
        )),
    }
}

fn create(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: width.max(height).ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rising(width: u32, height: u32) -> Image {
        let pixels = (0..width * height).map(|i| [i as f32, 1.0, -0.5]).collect();
        Image::new(width, height, pixels).unwrap()
    }

    #[test]
    fn an_image_of_several_bands_arrives_whole() {
        let gpu = Gpu::for_tests();
        let height = 2 * BAND_BYTES as u32 / 12 / 4096 + 7;
        let image = rising(4096, height);
        let texture = Texture::upload(&gpu, &image).unwrap();
        let expected = image.pixels().iter().map(|&[r, g, b]| [r, g, b, 0.0]);
        assert!(texture.read(&gpu, 0).into_iter().eq(expected));
    }

    #[test]
    fn a_smaller_level_has_the_mean_of_four_pixels() {
        let gpu = Gpu::for_tests();
        let texture = Texture::upload(&gpu, &rising(5, 2)).unwrap();
        assert_eq!(texture.read(&gpu, 1), [[3.0, 1.0, -0.5, 0.0], [5.0, 1.0, -0.5, 0.0]]);
        assert_eq!(texture.read(&gpu, 2), [[4.0, 1.0, -0.5, 0.0]]);
        let column = Texture::upload(&gpu, &rising(1, 10)).unwrap();
        assert_eq!(column.read(&gpu, 1)[4][0], 8.5);
    }

    #[test]
    fn broken_pixels_are_marked_and_do_not_spread() {
        let gpu = Gpu::for_tests();
        for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut image = Image::filled(2, 1, [0.5; 3]).unwrap();
            image.pixels_mut()[1] = [1.0, broken, 1.0];
            let texture = Texture::upload(&gpu, &image).unwrap();
            assert_eq!(texture.read(&gpu, 0), [[0.5, 0.5, 0.5, 0.0], [0.0, 0.0, 0.0, 1.0]]);
        }
    }
}
