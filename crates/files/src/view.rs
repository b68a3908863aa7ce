//! What is denoised in a file: its views, each with its layers.

use super::motion::MotionLayer;
use super::selection::Selection;
use super::{Problem, window};
use wgdenoise::Image;

/// One view of a picture, such as the left eye's; most files have one.
///
/// Further layers are held in memory along with the color: a part with many layers is unpacked only
/// once, and their results wait for each other anyway until the file is written.
#[derive(Debug)]
pub struct View {
    pub(super) name: Option<String>,
    pub(super) color: Image,
    pub(super) albedo: Option<Image>,
    pub(super) normal: Option<Image>,
    pub(super) alpha: Option<Vec<f32>>,
    pub(super) layers: Vec<NoisyLayer>,
    pub(super) motion: Option<MotionLayer>,
    pub(super) selection: Option<Selection>,
    pub(super) corner: [i32; 2],
    pub(super) is_panorama: bool,
}

/// A further light layer, to be denoised with the color's weights.
#[derive(Clone, Debug)]
pub struct NoisyLayer {
    /// The layer's name in the file.
    pub name: String,
    /// Linear light, of the color's size.
    pub image: Image,
}

/// The replacements for a [`View`]'s noisy images. Each image has the color's size.
#[derive(Clone, Debug)]
pub struct Denoised {
    /// Replaces the color.
    pub color: Image,
    /// Replaces the alpha; with `None`, the file's alpha stays as it is.
    pub alpha: Option<Vec<f32>>,
    /// Replace [`View::layers`], in the same order; if empty, those layers stay as they are.
    pub layers: Vec<Image>,
}

impl From<Image> for Denoised {
    /// Leaves alpha and further layers as they are.
    fn from(color: Image) -> Self {
        Self { color, alpha: None, layers: Vec::new() }
    }
}

impl View {
    /// The view of a file without layers.
    pub(super) fn of_color(color: Image, alpha: Option<Vec<f32>>) -> Self {
        Self {
            name: None,
            color,
            albedo: None,
            normal: None,
            alpha,
            layers: Vec::new(),
            motion: None,
            selection: None,
            corner: [0; 2],
            is_panorama: false,
        }
    }

    /// The view's name, such as `left`; `None` if the file names no views.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The noisy color: linear, and scene-referred unless the file is PNG or JPEG.
    #[must_use]
    pub fn color(&self) -> &Image {
        &self.color
    }

    /// The albedo in [0, 1], of the color's size.
    #[must_use]
    pub fn albedo(&self) -> Option<&Image> {
        self.albedo.as_ref()
    }

    /// The normals in [−1, 1], of the color's size.
    #[must_use]
    pub fn normal(&self) -> Option<&Image> {
        self.normal.as_ref()
    }

    /// The alpha of the color's layer, row by row, by which the color is premultiplied.
    #[must_use]
    pub fn alpha(&self) -> Option<&[f32]> {
        self.alpha.as_deref()
    }

    /// Whether any pixel is partly transparent.
    #[must_use]
    pub fn has_fractional_alpha(&self) -> bool {
        self.alpha.as_ref().is_some_and(|alpha| alpha.iter().any(|&a| a > 0.0 && a < 1.0))
    }

    /// The further layers to denoise with the color's weights, as chosen by [`LayerChoice`].
    ///
    /// [`LayerChoice`]: crate::LayerChoice
    #[must_use]
    pub fn layers(&self) -> &[NoisyLayer] {
        &self.layers
    }

    /// The motion vectors, if [`LayerChoice`](crate::LayerChoice) asks for them.
    #[must_use]
    pub fn motion(&self) -> Option<&MotionLayer> {
        self.motion.as_ref()
    }

    /// Where the color's first pixel is in the picture, in pixels right and down; EXR files may
    /// hold only a part of the picture.
    #[must_use]
    pub fn corner(&self) -> [i32; 2] {
        self.corner
    }

    /// The layers that were read; `None` for PNG and JPEG, which have none.
    #[must_use]
    pub fn selection(&self) -> Option<&Selection> {
        self.selection.as_ref()
    }

    /// Whether the left and right edges of the picture touch: it is an EXR file whose `envmap`
    /// attribute says latlong.
    #[must_use]
    pub fn is_panorama(&self) -> bool {
        self.is_panorama
    }

    /// Refuses a result that does not fit the view.
    pub(super) fn check(&self, result: &Denoised) -> Result<(), Problem> {
        let size = self.color.size();
        let images = [&result.color].into_iter().chain(&result.layers);
        if let Some(other) = images.map(Image::size).find(|other| *other != size) {
            return Err(window::other_size(other, size));
        }
        let pixels = self.color.pixels().len();
        if result.alpha.as_ref().is_some_and(|alpha| alpha.len() != pixels) {
            return Err(Problem::Size("cannot be written: the alpha is not of its size".into()));
        }
        if !result.layers.is_empty() && result.layers.len() != self.layers.len() {
            let (given, expected) = (result.layers.len(), self.layers.len());
            return Err(Problem::Size(format!(
                "cannot be written: {given} further layers are given and {expected} were read"
            )));
        }
        Ok(())
    }
}
