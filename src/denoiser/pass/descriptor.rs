//! The inputs, output and settings of a pass.

use super::PassImage;
use super::image::{Role, refuse_unless};
use crate::denoiser::frame::check_input_scale;
use crate::error::{Error, Result};
use crate::model::Inputs;
use crate::plan::tiles::MAX_SIDE;

/// The factor that brings color to the exposure the network was trained at.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum InputScale<'a> {
    /// Measured on the GPU in every frame: 0.18 over the geometric mean of the luminance, dark
    /// backgrounds aside. Always 1 for weights that do not read unbounded light
    /// ([`TransferFunction::is_hdr`](crate::TransferFunction::is_hdr)).
    #[default]
    Auto,
    /// A constant: finite, normal (not subnormal) and above 0.
    Value(f32),
    /// The 32-bit float at the start of a storage buffer, read in every frame, for renderers that
    /// measure their own exposure. It must be positive, finite and normal; any other value spoils
    /// the frame.
    Buffer(&'a wgpu::Buffer),
}

/// How normals are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NormalEncoding {
    /// Stored directly: components in `[−1, 1]`, all 0 where no surface was hit.
    #[default]
    Signed,
    /// Stored as `0.5 n + 0.5`: components in `[0, 1]`, all 0 or all 0.5 where no surface was hit.
    Unorm,
}

/// A further image of the view, filtered with the color's kernels; see
/// [`Denoiser::denoise_layers`](crate::Denoiser::denoise_layers).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PassLayer<'a> {
    /// The noisy layer, in a format for colors: linear light that is part of the color, or other
    /// data that is averaged with it, such as alpha.
    pub noisy: PassImage<'a>,
    /// Receives the denoised layer, in a format for outputs.
    pub output: PassImage<'a>,
    /// Whether the layer is light: `true` by default. Light follows the texture of its surface, so
    /// weights that demodulate multiply its mean by the ratio of the albedo to the albedo's mean.
    /// They leave the means of other layers alone.
    pub light: bool,
}

impl<'a> PassLayer<'a> {
    /// A layer of light, and the image that receives its denoised version.
    #[must_use]
    pub fn new(noisy: PassImage<'a>, output: PassImage<'a>) -> Self {
        Self { noisy, output, light: true }
    }

    /// Sets whether the layer is light.
    #[must_use]
    pub fn light(self, light: bool) -> Self {
        Self { light, ..self }
    }
}

/// The images a pass reads and writes, in any mix of textures and buffers.
///
/// | image | texture formats | alpha |
/// |---|---|---|
/// | color, output | `Rgba16Float`, `Rgba32Float` | copied from color, or 1 if color has none |
/// | albedo | the same, `Rgba8Unorm`, `Rgba8UnormSrgb` | ignored |
/// | normal | the same as color, `Rgba8Snorm`; with [`NormalEncoding::Unorm`] `Rgba8Unorm`, `Rgb10a2Unorm` | ignored |
/// | motion | `Rg16Float`, `Rg32Float`, `Rgba16Float`, `Rgba32Float` | ignored |
/// | depth | `R16Float`, `R32Float` | |
///
/// In a buffer, motion has at least two channels and depth at least one
/// ([`Layout::packed_channels`](crate::Layout::packed_channels)); all others have three or four.
///
/// An output may share its texture or buffer with color or another input. The pass first copies
/// such an input into memory of its own, so it needs the usage `COPY_SRC`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PassDescriptor<'a> {
    /// Width of every image, 1 to 65536 pixels.
    pub width: u32,
    /// Height of every image, 1 to 65536 pixels.
    pub height: u32,
    /// Linear, scene-referred color at any exposure. NaN pixels are filled from their neighbors,
    /// and infinite light becomes very bright.
    pub color: PassImage<'a>,
    /// Linear albedo in `[0, 1]`: the surface's reflectance, 0 where no surface was hit.
    pub albedo: Option<PassImage<'a>>,
    /// Normal of the first surface, in world or camera space.
    pub normal: Option<PassImage<'a>>,
    /// How the normals are stored.
    pub normal_encoding: NormalEncoding,
    /// Motion vectors: where each pixel's surface was in the last frame, relative to the pixel, in
    /// pixels, x right, y down. With them, the pass averages each frame with the last ones to
    /// reduce flicker. A vector that is NaN, infinite or leads out of the image means that the
    /// surface was not seen. Motion takes 48 bytes per pixel more, plus 8 for each of albedo,
    /// normal and depth, and with layers 4 plus 32 per layer.
    pub motion: Option<PassImage<'a>>,
    /// Distance of the surface from the camera's plane, linear, in any unit; 0, infinite or NaN
    /// where nothing was hit. Tells apart surfaces that motion confuses; requires motion.
    pub depth: Option<PassImage<'a>>,
    /// Receives the denoised color at the input's exposure. Finite values beyond the range of a
    /// 16-bit format become ±65504.
    pub output: PassImage<'a>,
    /// The factor that brings color to the exposure the network was trained at.
    pub input_scale: InputScale<'a>,
    /// Further images, filtered with the color's kernels and, with motion, averaged with the
    /// color's weights, so that layers that add up to the color still do. The network's weights
    /// must predict a kernel pyramid, as the built-in ones do.
    pub layers: &'a [PassLayer<'a>],
}

impl<'a> PassDescriptor<'a> {
    /// Color alone, with measured exposure.
    #[must_use]
    pub fn new(width: u32, height: u32, color: PassImage<'a>, output: PassImage<'a>) -> Self {
        Self {
            width,
            height,
            color,
            albedo: None,
            normal: None,
            normal_encoding: NormalEncoding::Signed,
            motion: None,
            depth: None,
            output,
            input_scale: InputScale::Auto,
            layers: &[],
        }
    }

    /// Replaces the color.
    #[must_use]
    pub fn color(self, color: PassImage<'a>) -> Self {
        Self { color, ..self }
    }

    /// Replaces the output.
    #[must_use]
    pub fn output(self, output: PassImage<'a>) -> Self {
        Self { output, ..self }
    }

    /// Sets or clears the albedo.
    #[must_use]
    pub fn albedo(self, albedo: impl Into<Option<PassImage<'a>>>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// Sets or clears the normal.
    #[must_use]
    pub fn normal(self, normal: impl Into<Option<PassImage<'a>>>) -> Self {
        Self { normal: normal.into(), ..self }
    }

    /// Sets how the normals are stored.
    #[must_use]
    pub fn normal_encoding(self, normal_encoding: NormalEncoding) -> Self {
        Self { normal_encoding, ..self }
    }

    /// Sets or clears the motion.
    #[must_use]
    pub fn motion(self, motion: impl Into<Option<PassImage<'a>>>) -> Self {
        Self { motion: motion.into(), ..self }
    }

    /// Sets or clears the depth.
    #[must_use]
    pub fn depth(self, depth: impl Into<Option<PassImage<'a>>>) -> Self {
        Self { depth: depth.into(), ..self }
    }

    /// Sets the input scale.
    #[must_use]
    pub fn input_scale(self, input_scale: InputScale<'a>) -> Self {
        Self { input_scale, ..self }
    }

    /// Sets the further images to denoise.
    #[must_use]
    pub fn layers(self, layers: &'a [PassLayer<'a>]) -> Self {
        Self { layers, ..self }
    }

    /// The auxiliary images that this pass has.
    pub(super) fn inputs(&self) -> Inputs {
        Inputs { albedo: self.albedo.is_some(), normal: self.normal.is_some() }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    pub(super) fn unorm_normal(&self) -> bool {
        self.normal_encoding == NormalEncoding::Unorm
    }

    pub(super) fn check(&self, limits: &wgpu::Limits) -> Result<()> {
        let [width, height] = self.size();
        let sides = 1..=MAX_SIDE;
        refuse_unless(sides.contains(&width) && sides.contains(&height), || {
            format!("{width}×{height}: both sides must be at least 1 and at most {MAX_SIDE}")
        })?;
        for (role, image) in self.outputs() {
            image.check(role, self.size(), limits)?;
        }
        for (role, image) in self.sources() {
            image.check(role, self.size(), limits)?;
            if self.overwrites(&image) {
                image.check_copy(role)?;
            }
        }
        self.check_outputs()?;
        self.check_motion()?;
        self.check_input_scale()
    }

    fn check_motion(&self) -> Result<()> {
        refuse_unless(self.motion.is_some() || self.depth.is_none(), || {
            "depth only tells whether the last frame shows the same surface, which needs motion; \
             set motion too or leave out depth"
                .into()
        })
    }

    /// Whether an output shares the image's texture or buffer.
    pub(super) fn overwrites(&self, image: &PassImage<'_>) -> bool {
        self.outputs().any(|(_, output)| image.shares_memory(&output))
    }

    fn sources(&self) -> impl Iterator<Item = (Role, PassImage<'a>)> + use<'a> {
        let normal = Role::Normal { unorm: self.unorm_normal() };
        let all = [
            (Role::Color, Some(self.color)),
            (Role::Albedo, self.albedo),
            (normal, self.normal),
            (Role::Motion, self.motion),
            (Role::Depth, self.depth),
        ];
        let layers = (0..).zip(self.layers).map(|(i, layer)| (Role::Layer(i), Some(layer.noisy)));
        all.into_iter().chain(layers).filter_map(|(role, image)| Some((role, image?)))
    }

    fn outputs(&self) -> impl Iterator<Item = (Role, PassImage<'a>)> + use<'a> {
        let layers = (0..).zip(self.layers).map(|(i, layer)| (Role::LayerOutput(i), layer.output));
        std::iter::once((Role::Output, self.output)).chain(layers)
    }

    /// Rejects a texture used for two outputs. Outputs may share a buffer.
    fn check_outputs(&self) -> Result<()> {
        let outputs: Vec<_> = self.outputs().collect();
        for (i, (role, image)) in outputs.iter().enumerate() {
            let PassImage::Texture(_) = image else { continue };
            let twice = outputs[..i].iter().find(|(_, other)| image.shares_memory(other));
            if let Some((first, _)) = twice {
                return Err(Error::Image(format!(
                    "{first} and {role} are the same texture; give each one of its own"
                )));
            }
        }
        Ok(())
    }

    fn check_input_scale(&self) -> Result<()> {
        match self.input_scale {
            InputScale::Auto => Ok(()),
            InputScale::Value(scale) => check_input_scale(Some(scale)),
            InputScale::Buffer(buffer) => {
                self.outputs().try_for_each(|(_, output)| check_scale_buffer(buffer, &output))
            }
        }
    }
}

fn check_scale_buffer(buffer: &wgpu::Buffer, output: &PassImage<'_>) -> Result<()> {
    refuse_unless(buffer.size() >= 4, || {
        format!("the buffer of the input scale has {} bytes, expected at least 4", buffer.size())
    })?;
    refuse_unless(buffer.usage().contains(wgpu::BufferUsages::STORAGE), || {
        "the buffer of the input scale was created without the usage STORAGE; add it".into()
    })?;
    match output {
        PassImage::Buffer { buffer: output, .. } if *output == buffer => Err(Error::Image(
            "the input scale is in the buffer of the output, which no kernel can write while \
             it reads the scale; give the scale a buffer of its own"
                .into(),
        )),
        _ => Ok(()),
    }
}
