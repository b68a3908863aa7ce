//! Compiling ahead.

use super::{InputScale, NormalEncoding, PassDescriptor, PassImage};
use crate::denoiser::Denoiser;
use crate::error::Result;
use crate::ops::image::ImageFormat;
use crate::ops::tile::Layout;

/// How the images of a pass to come are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PassFormats {
    /// Of colour.
    pub color: ImageFormat,
    /// Of albedo, if there is one.
    pub albedo: Option<ImageFormat>,
    /// Of the normal, if there is one.
    pub normal: Option<ImageFormat>,
    /// How the normal is stored.
    pub normal_encoding: NormalEncoding,
    /// Of the output.
    pub output: ImageFormat,
}

/// An image of one pixel.
enum Pixel {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

impl Denoiser {
    /// Compiles what a [`pass`](Self::pass) over images in these formats needs, of any size, so
    /// that making one later takes no longer than its memory does. Worth a thread of its own at
    /// the start of a program: compiling takes up to seconds.
    ///
    /// # Errors
    /// If a pass would refuse the formats.
    pub fn warm_up(&self, formats: &PassFormats) -> Result<()> {
        let input = |format| self.pixel(format, wgpu::TextureUsages::TEXTURE_BINDING);
        let (color, albedo, normal) =
            (input(formats.color)?, formats.albedo.map(input), formats.normal.map(input));
        let (albedo, normal) = (albedo.transpose()?, normal.transpose()?);
        let output = self.pixel(formats.output, wgpu::TextureUsages::STORAGE_BINDING)?;
        self.pass(&PassDescriptor {
            width: 1,
            height: 1,
            color: color.image(formats.color),
            albedo: albedo.as_ref().zip(formats.albedo).map(|(pixel, format)| pixel.image(format)),
            normal: normal.as_ref().zip(formats.normal).map(|(pixel, format)| pixel.image(format)),
            normal_encoding: formats.normal_encoding,
            output: output.image(formats.output),
            input_scale: InputScale::Auto,
        })?;
        Ok(())
    }

    fn pixel(&self, format: ImageFormat, usage: wgpu::TextureUsages) -> Result<Pixel> {
        let device = &self.context.device;
        self.context.catch(|| {
            Ok(match format {
                ImageFormat::Texture(format) => Pixel::Texture(one_texel(device, format, usage)),
                ImageFormat::Buffer(_) => {
                    Pixel::Buffer(device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some("warm-up"),
                        size: 16,
                        usage: wgpu::BufferUsages::STORAGE,
                        mapped_at_creation: false,
                    }))
                }
            })
        })
    }
}

impl Pixel {
    fn image(&self, format: ImageFormat) -> PassImage<'_> {
        match (self, format) {
            (Self::Buffer(buffer), ImageFormat::Buffer(element)) => {
                PassImage::Buffer { buffer, element, layout: Layout::packed(1) }
            }
            (Self::Texture(texture), _) => PassImage::Texture(texture),
            (Self::Buffer(_), ImageFormat::Texture(_)) => {
                unreachable!("it was made for its format")
            }
        }
    }
}

fn one_texel(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("warm-up"),
        size: wgpu::Extent3d::default(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
