//! Images as textures: linear light in 32-bit float, with smaller levels for small zooms.

use wgdenoise::{Image, wgpu};

use crate::gpu::host::Gpu;

/// Bytes of a pixel.
const PIXEL: u32 = 16;

/// Red, green and blue; the last is 1 for a pixel with a value that is no finite number.
type Texel = [f32; 4];

/// An image on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct Texture {
    view: wgpu::TextureView,
}

impl Texture {
    pub(crate) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Uploads an image. May be called from any thread.
    ///
    /// # Errors
    /// If the device allows no image so large, or its memory is full.
    pub(crate) fn upload(gpu: &Gpu, image: &Image) -> Result<Self, String> {
        let most = gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = image.size();
        if width.max(height) > most {
            return Err(format!(
                "an image of {width}×{height} pixels cannot be shown: the adapter shows at most \
                 {most} pixels a side"
            ));
        }
        let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = create(&gpu.device, [width, height]);
        write_levels(&gpu.queue, &texture, texels(image), [width, height]);
        match pollster::block_on(memory.pop()) {
            None => Ok(Self { view: texture.create_view(&Default::default()) }),
            Some(_) => Err(format!(
                "the adapter has no memory to show an image of {width}×{height} pixels; close \
                 other programs or open a smaller image"
            )),
        }
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
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn texels(image: &Image) -> Vec<Texel> {
    let texel = |[r, g, b]: &[f32; 3]| {
        let is_broken = [r, g, b].iter().any(|v| !v.is_finite());
        if is_broken { [0.0, 0.0, 0.0, 1.0] } else { [*r, *g, *b, 0.0] }
    };
    image.pixels().iter().map(texel).collect()
}

fn write_levels(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    mut texels: Vec<Texel>,
    mut size: [u32; 2],
) {
    for level in 0..texture.mip_level_count() {
        if level > 0 {
            (texels, size) = halved(&texels, size);
        }
        let [width, height] = size;
        let place = wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * PIXEL),
            rows_per_image: None,
        };
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        queue.write_texture(place, bytemuck::cast_slice(&texels), layout, extent);
    }
}

/// The mean of two by two pixels, or of as many as there are.
fn halved(texels: &[Texel], size: [u32; 2]) -> (Vec<Texel>, [u32; 2]) {
    let smaller = size.map(|side| (side / 2).max(1));
    let last = size.map(|side| side - 1);
    let at = |x: u32, y: u32| texels[(y.min(last[1]) * size[0] + x.min(last[0])) as usize];
    let mean = |x: u32, y: u32| {
        let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        [0, 1, 2, 3].map(|channel| four.iter().map(|texel| texel[channel] / 4.0).sum())
    };
    let row = |y: u32| (0..smaller[0]).map(move |x| (2 * x, 2 * y));
    let places = (0..smaller[1]).flat_map(row);
    (places.map(|(x, y)| mean(x, y)).collect(), smaller)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smaller_level_has_the_mean_of_four_pixels() {
        let texels: Vec<Texel> = (0..10).map(|i| [i as f32, 1.0, 0.0, 0.0]).collect();
        let (half, size) = halved(&texels, [5, 2]);
        assert_eq!(size, [2, 1]);
        assert_eq!(half, [[3.0, 1.0, 0.0, 0.0], [5.0, 1.0, 0.0, 0.0]]);
        let (column, size) = halved(&texels, [1, 10]);
        assert_eq!((column[0][0], size), (0.5, [1, 5]));
    }

    #[test]
    fn broken_pixels_are_marked_and_do_not_spread() {
        let mut image = Image::filled(2, 1, [0.5; 3]).unwrap();
        image.pixels_mut()[1] = [1.0, f32::NAN, 1.0];
        assert_eq!(texels(&image), [[0.5, 0.5, 0.5, 0.0], [0.0, 0.0, 0.0, 1.0]]);
    }
}
