//! Images on the GPU in every format that a pass accepts.

use wgdenoise::{Image, ImageFormat, Layout, PassImage, wgpu};

use super::gpu::{buffer, context, read_back};
use super::pixels::{decode, encode};

/// A pixel: red, green, blue, alpha.
pub type Pixel = [f32; 4];

/// An image on the GPU. Gaps between the pixels of a buffer are filled with `0xff`.
pub struct GpuImage {
    place: Place,
    format: ImageFormat,
    layout: Layout,
    size: [u32; 2],
}

enum Place {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

impl GpuImage {
    /// An image of `pixels`; `size` has the width first. The layout applies to buffers only.
    pub fn new(pixels: &[Pixel], size: [u32; 2], format: ImageFormat, layout: Layout) -> Self {
        let context = context(wgdenoise::Precision::F32);
        let place = match format {
            ImageFormat::Texture(texture) => Place::Texture(create(size, texture)),
            ImageFormat::Buffer(element) => {
                let bytes = layout.elements(size[0], size[1]) as usize * element.bytes() as usize;
                Place::Buffer(buffer(context, &vec![0xff; bytes.next_multiple_of(4)]))
            }
        };
        let image = Self { place, format, layout, size };
        image.write(pixels);
        image
    }

    /// Replaces the pixels, for work that is submitted later.
    pub fn write(&self, pixels: &[Pixel]) {
        let context = context(wgdenoise::Precision::F32);
        match (&self.place, self.format) {
            (Place::Buffer(buffer), ImageFormat::Buffer(element)) => {
                let mut contents = vec![0xff; buffer.size() as usize];
                let ranges = ranges(self.size, element.bytes(), self.layout);
                for (range, pixel) in ranges.zip(pixels) {
                    let length = range.len();
                    contents[range].copy_from_slice(&encode(self.format, *pixel)[..length]);
                }
                context.queue.write_buffer(buffer, 0, &contents);
            }
            (Place::Texture(texture), format) => {
                let bytes: Vec<u8> = pixels.iter().flat_map(|p| encode(format, *p)).collect();
                let [width, height] = self.size;
                let layout = copy_layout(width * texel_bytes(texture.format()), height);
                let target = texture.as_image_copy();
                context.queue.write_texture(target, &bytes, layout, texture.size());
            }
            _ => unreachable!("a buffer has a buffer format"),
        }
    }

    pub fn as_pass(&self) -> PassImage<'_> {
        match (&self.place, self.format) {
            (Place::Buffer(buffer), ImageFormat::Buffer(element)) => {
                PassImage::Buffer { buffer, element, layout: self.layout }
            }
            (Place::Texture(texture), _) => PassImage::Texture(texture),
            _ => unreachable!("a buffer has a buffer format"),
        }
    }

    /// Returns the pixels after the `record`ed work; alpha is NaN if the layout has none.
    pub fn read(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Vec<Pixel> {
        match &self.place {
            Place::Texture(texture) => self.read_texture(texture, record),
            Place::Buffer(buffer) => {
                let bytes = read_buffer(buffer, record);
                let ImageFormat::Buffer(element) = self.format else { unreachable!() };
                let pixel = |range: std::ops::Range<usize>| {
                    let mut four = encode(self.format, [f32::NAN; 4]);
                    four[..range.len()].copy_from_slice(&bytes[range]);
                    decode(self.format, &four)
                };
                ranges(self.size, element.bytes(), self.layout).map(pixel).collect()
            }
        }
    }

    /// Whether all bytes between the pixels of a buffer are untouched.
    pub fn gaps_are_untouched(&self) -> bool {
        let (Place::Buffer(buffer), ImageFormat::Buffer(element)) = (&self.place, self.format)
        else {
            return true;
        };
        let mut bytes = read_buffer(buffer, |_| {});
        ranges(self.size, element.bytes(), self.layout).for_each(|range| bytes[range].fill(0xff));
        bytes.iter().all(|&byte| byte == 0xff)
    }

    fn read_texture(
        &self,
        texture: &wgpu::Texture,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Vec<Pixel> {
        let [width, height] = self.size;
        let texel = texel_bytes(texture.format());
        let row = (width * texel).next_multiple_of(256);
        let context = context(wgdenoise::Precision::F32);
        let bytes = read_back(context, u64::from(row * height), |encoder, buffer| {
            record(encoder);
            let layout = copy_layout(row, height);
            let target = wgpu::TexelCopyBufferInfo { buffer, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
        });
        let rows = bytes.chunks_exact(row as usize).map(|row| &row[..(width * texel) as usize]);
        let texels = rows.flat_map(|row| row.chunks_exact(texel as usize));
        texels.map(|texel| decode(self.format, texel)).collect()
    }
}

fn read_buffer(buffer: &wgpu::Buffer, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Vec<u8> {
    read_back(context(wgdenoise::Precision::F32), buffer.size(), |encoder, target| {
        record(encoder);
        encoder.copy_buffer_to_buffer(buffer, 0, target, 0, buffer.size());
    })
}

/// Rounds pixels to a format.
pub fn quantized(pixels: &[Pixel], format: ImageFormat) -> Vec<Pixel> {
    pixels.iter().map(|&pixel| decode(format, &encode(format, pixel))).collect()
}

/// Converts the pixels' colors to an image on the CPU.
pub fn cpu_image(pixels: &[Pixel], [width, height]: [u32; 2]) -> Image {
    let rgb = pixels.iter().map(|&[r, g, b, _]| [r, g, b]);
    Image::new(width, height, rgb.collect()).expect("the count is right")
}

/// The byte range of each pixel in a buffer.
fn ranges(
    [width, height]: [u32; 2],
    element_bytes: u32,
    layout: Layout,
) -> impl Iterator<Item = std::ops::Range<usize>> {
    let at = move |x: u32, y: u32| {
        let first = layout.offset + y * layout.row_stride + x * layout.pixel_stride;
        let [begin, end] = [first, first + layout.channels()].map(|i| (i * element_bytes) as usize);
        begin..end
    };
    (0..height).flat_map(move |y| (0..width).map(move |x| at(x, y)))
}

fn create(size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
    let mut usage = wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST;
    let float = [wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Rgba32Float];
    usage.set(wgpu::TextureUsages::STORAGE_BINDING, float.contains(&format));
    let device = &context(wgdenoise::Precision::F32).device;
    device.create_texture(&descriptor(size, format, usage))
}

/// A two-dimensional texture.
pub fn descriptor(
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

fn texel_bytes(format: wgpu::TextureFormat) -> u32 {
    format.block_copy_size(None).expect("a color format")
}

fn copy_layout(row: u32, height: u32) -> wgpu::TexelCopyBufferLayout {
    let (bytes_per_row, rows_per_image) = (Some(row), Some(height));
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image }
}
