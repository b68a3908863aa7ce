//! Compiling a pass's kernels ahead of time.

use super::held::texture;
use super::image::{Role, check_format};
use super::{InputScale, NormalEncoding, PassDescriptor, PassImage, PassLayer};
use crate::denoiser::Denoiser;
use crate::error::Result;
use crate::gpu::scopes::catch;
use crate::ops::image::ImageFormat;
use crate::ops::tile::Layout;

/// The storage formats of a future pass's images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct PassFormats {
    /// Format of the color.
    pub color: ImageFormat,
    /// Format of the albedo.
    pub albedo: Option<ImageFormat>,
    /// Format of the normal.
    pub normal: Option<ImageFormat>,
    /// How the normals are stored.
    pub normal_encoding: NormalEncoding,
    /// Format of the motion.
    pub motion: Option<ImageFormat>,
    /// Format of the depth.
    pub depth: Option<ImageFormat>,
    /// Format of the output.
    pub output: ImageFormat,
    /// Formats of each further layer, if there are any.
    pub layer: Option<LayerFormats>,
}

/// The storage formats of a further layer of a future pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LayerFormats {
    /// Format of the noisy layer.
    pub noisy: ImageFormat,
    /// Format of its output.
    pub output: ImageFormat,
}

impl PassFormats {
    /// Color alone.
    #[must_use]
    pub fn new(color: ImageFormat, output: ImageFormat) -> Self {
        Self {
            color,
            albedo: None,
            normal: None,
            normal_encoding: NormalEncoding::Signed,
            motion: None,
            depth: None,
            output,
            layer: None,
        }
    }

    /// Replaces the color's format.
    #[must_use]
    pub fn color(self, color: ImageFormat) -> Self {
        Self { color, ..self }
    }

    /// Replaces the output's format.
    #[must_use]
    pub fn output(self, output: ImageFormat) -> Self {
        Self { output, ..self }
    }

    /// Sets or clears the albedo's format.
    #[must_use]
    pub fn albedo(self, albedo: impl Into<Option<ImageFormat>>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// Sets or clears the normal's format.
    #[must_use]
    pub fn normal(self, normal: impl Into<Option<ImageFormat>>) -> Self {
        Self { normal: normal.into(), ..self }
    }

    /// Sets how the normals are stored.
    #[must_use]
    pub fn normal_encoding(self, normal_encoding: NormalEncoding) -> Self {
        Self { normal_encoding, ..self }
    }

    /// Sets or clears the motion's format.
    #[must_use]
    pub fn motion(self, motion: impl Into<Option<ImageFormat>>) -> Self {
        Self { motion: motion.into(), ..self }
    }

    /// Sets or clears the depth's format.
    #[must_use]
    pub fn depth(self, depth: impl Into<Option<ImageFormat>>) -> Self {
        Self { depth: depth.into(), ..self }
    }

    /// Sets or clears the formats of further layers.
    #[must_use]
    pub fn layer(self, layer: impl Into<Option<LayerFormats>>) -> Self {
        Self { layer: layer.into(), ..self }
    }
}

/// A one-pixel image.
enum Pixel {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

impl Denoiser {
    /// Compiles the kernels for a [`pass`](Self::pass) over images in these formats, at any size.
    /// Creating that pass later then only allocates memory. Compiling takes up to seconds, so run
    /// it on a thread of its own at start-up.
    ///
    /// # Errors
    /// Fails if a pass would reject the formats.
    pub fn warm_up(&self, formats: &PassFormats) -> Result<()> {
        let unorm = formats.normal_encoding == NormalEncoding::Unorm;
        let optional = |role, format: Option<ImageFormat>| {
            let pixel = |format| Ok((self.pixel(role, format)?, format));
            format.map(pixel).transpose()
        };
        let color = self.pixel(Role::Color, formats.color)?;
        let albedo = optional(Role::Albedo, formats.albedo)?;
        let normal = optional(Role::Normal { unorm }, formats.normal)?;
        let motion = optional(Role::Motion, formats.motion)?;
        let depth = optional(Role::Depth, formats.depth)?;
        let output = self.pixel(Role::Output, formats.output)?;
        let layer = formats.layer.map(|layer| {
            let noisy = self.pixel(Role::Layer(0), layer.noisy)?;
            let output = || self.pixel(Role::LayerOutput(0), layer.output);
            Ok((layer, noisy, [(true, output()?), (false, output()?)]))
        });
        let layer = layer.transpose()?;
        let kinds = layer.iter().flat_map(|(of, noisy, outputs)| {
            outputs.each_ref().map(|(light, output)| {
                PassLayer::new(noisy.image(of.noisy), output.image(of.output)).light(*light)
            })
        });
        let layers: Vec<_> = kinds.collect();
        self.pass(&PassDescriptor {
            width: 1,
            height: 1,
            color: color.image(formats.color),
            albedo: present(albedo.as_ref()),
            normal: present(normal.as_ref()),
            normal_encoding: formats.normal_encoding,
            motion: present(motion.as_ref()),
            depth: present(depth.as_ref()),
            output: output.image(formats.output),
            input_scale: InputScale::Auto,
            layers: &layers,
        })?;
        Ok(())
    }

    fn pixel(&self, role: Role, format: ImageFormat) -> Result<Pixel> {
        let device = &self.context.device;
        let (usage, _) = role.texture_usage();
        if let ImageFormat::Texture(format) = format {
            check_format(role, format)?;
        }
        catch(device, || {
            Ok(match format {
                ImageFormat::Texture(format) => {
                    Pixel::Texture(texture(device, [1, 1], format, usage))
                }
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

fn present(image: Option<&(Pixel, ImageFormat)>) -> Option<PassImage<'_>> {
    image.map(|(pixel, format)| pixel.image(*format))
}

impl Pixel {
    fn image(&self, format: ImageFormat) -> PassImage<'_> {
        match (self, format) {
            (Self::Buffer(buffer), ImageFormat::Buffer(element)) => {
                PassImage::Buffer { buffer, element, layout: Layout::packed(1) }
            }
            (Self::Texture(texture), _) => PassImage::Texture(texture),
            (Self::Buffer(_), ImageFormat::Texture(_)) => {
                unreachable!("the image was created in this format")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, Options, Quality, Weights};
    use wgpu::TextureFormat::{
        R32Float, Rg16Float, Rgba8Snorm, Rgba8Unorm, Rgba16Float, Rgba32Float,
    };

    fn formats() -> PassFormats {
        PassFormats::new(ImageFormat::Texture(Rgba32Float), ImageFormat::Texture(Rgba16Float))
            .albedo(ImageFormat::Texture(Rgba8Unorm))
            .normal(ImageFormat::Texture(Rgba8Snorm))
    }

    /// The number of kernels that a pass of this size compiles on top of the existing ones, with or
    /// without motion, and with this many layers.
    fn compiles(
        denoiser: &Denoiser,
        [width, height]: [u32; 2],
        moves: bool,
        layers: usize,
    ) -> usize {
        let before = denoiser.context.compiled();
        let create =
            |format, usage| texture(&denoiser.context.device, [width, height], format, usage);
        let input = |format| create(format, wgpu::TextureUsages::TEXTURE_BINDING);
        let [color, albedo, normal] = [Rgba32Float, Rgba8Unorm, Rgba8Snorm].map(input);
        let [motion, depth] = [Rg16Float, R32Float].map(input);
        let output = || create(Rgba16Float, wgpu::TextureUsages::STORAGE_BINDING);
        let outputs: Vec<_> = (0..layers).map(|_| output()).collect();
        let output = output();
        let [color, albedo, normal, output] =
            [&color, &albedo, &normal, &output].map(PassImage::Texture);
        let [motion, depth] =
            [&motion, &depth].map(|texture| moves.then_some(PassImage::Texture(texture)));
        let layer = |(i, output)| PassLayer::new(color, PassImage::Texture(output)).light(i == 0);
        let layers: Vec<_> = outputs.iter().enumerate().map(layer).collect();
        let descriptor = PassDescriptor::new(width, height, color, output)
            .albedo(albedo)
            .normal(normal)
            .motion(motion)
            .depth(depth)
            .layers(&layers);
        denoiser.pass(&descriptor).expect("the images fit");
        denoiser.context.compiled() - before
    }

    #[test]
    fn after_a_warm_up_and_after_another_size_nothing_is_left_to_compile() {
        let gpu = Gpu::open(None).expect("the tests need an adapter");
        let weights = Weights::builtin(Quality::Fast).expect("they are built in");
        let denoiser = || Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default());
        let [cold, warm] = [denoiser(), denoiser()].map(|denoiser| denoiser.expect("it works"));
        warm.warm_up(&formats()).expect("a pass takes them");
        let compiles = |denoiser, size| compiles(denoiser, size, false, 0);
        assert_eq!([compiles(&warm, [40, 30]), compiles(&warm, [64, 16])], [0, 0]);
        assert!(compiles(&cold, [40, 30]) > 0);
        assert_eq!(compiles(&cold, [64, 16]), 0);
    }

    #[test]
    fn motion_is_compiled_ahead_only_if_its_format_is_given() {
        let gpu = Gpu::open(None).expect("the tests need an adapter");
        let weights = Weights::builtin(Quality::Fast).expect("they are built in");
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())
            .expect("it works");
        denoiser.warm_up(&formats()).expect("a pass takes them");
        // The kernel that averages frames, and the network's last one for another output format.
        assert_eq!(compiles(&denoiser, [40, 30], true, 0), 2);
        let formats =
            formats().motion(ImageFormat::Texture(Rg16Float)).depth(ImageFormat::Texture(R32Float));
        let warm = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())
            .expect("it works");
        warm.warm_up(&formats).expect("a pass takes them");
        assert_eq!(compiles(&warm, [40, 30], true, 0), 0);
        // A layer's first kernel, its last for light and for other layers, the three between them,
        // the two that average it, and the one that averages the color next to it.
        assert_eq!(compiles(&warm, [40, 30], true, 3), 9);
        let [color, output] = [Rgba32Float, Rgba16Float].map(ImageFormat::Texture);
        let formats = formats.layer(LayerFormats { noisy: color, output });
        let warm = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default())
            .expect("it works");
        warm.warm_up(&formats).expect("a pass takes them");
        assert_eq!(compiles(&warm, [40, 30], true, 3), 0);
    }

    #[test]
    fn demodulation_is_compiled_ahead_for_light_and_other_layers() {
        let gpu = Gpu::open(None).expect("the tests need an adapter");
        let weights = include_bytes!("../../../tests/fixtures/demodulating_tiny.safetensors");
        let weights = Weights::from_bytes(weights).expect("the fixture follows the format");
        let denoiser = || {
            let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &Options::default());
            denoiser.expect("it works")
        };
        let [color, output] = [Rgba32Float, Rgba16Float].map(ImageFormat::Texture);
        let warm = denoiser();
        let layer = LayerFormats { noisy: color, output };
        warm.warm_up(&formats().layer(layer)).expect("a pass takes them");
        assert_eq!(compiles(&warm, [40, 30], false, 2), 0);
        // There are as many demodulating kernels as plain ones.
        let [with, without] = [formats(), formats().albedo(None)].map(|formats| {
            let denoiser = denoiser();
            denoiser.warm_up(&formats).expect("a pass takes them");
            denoiser.context.compiled()
        });
        assert_eq!(with, without);
    }
}
