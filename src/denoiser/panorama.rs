//! Panoramas: frames whose left and right edges touch.

use super::Denoiser;
use super::frame::{Denoised, Frame};
use super::progress::Progress;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::plan::tiles::MAX_SIDE;

/// A panorama extended by repeated columns on both sides, as many as the network's halo, so that
/// the seam is denoised like any other place.
#[derive(Debug)]
pub(crate) struct Wrapped {
    color: Image,
    albedo: Option<Image>,
    normal: Option<Image>,
    layers: Vec<Image>,
    input_scale: Option<f32>,
    /// The columns added on each side.
    pub(crate) columns: u32,
}

impl Denoiser {
    /// The width and height at which a frame is denoised. A panorama's width includes the columns
    /// repeated beyond both edges. [`tile_plan`](Self::tile_plan) and
    /// [`memory_bytes`](Self::memory_bytes) take this size.
    ///
    /// # Errors
    /// Fails if the panorama is too wide for these weights or the frame's images do not match.
    pub fn size_with_columns(&self, frame: &Frame<'_>) -> Result<(u32, u32)> {
        let frame = self.readable(frame)?;
        let (width, height) = frame.color.size();
        let columns = if frame.panorama { self.columns_beyond(&frame)? } else { 0 };
        Ok((width + 2 * columns, height))
    }

    /// The columns to repeat beyond each edge of a panorama.
    fn columns_beyond(&self, frame: &Frame<'_>) -> Result<u32> {
        let columns = self.network(frame.inputs())?.halo;
        let most = MAX_SIDE - 2 * columns;
        if frame.color.width() > most {
            return Err(Error::Image(format!(
                "with these weights, a panorama may be at most {most} pixels wide"
            )));
        }
        Ok(columns)
    }
}

impl Wrapped {
    pub(crate) fn new(denoiser: &Denoiser, frame: &Frame<'_>) -> Result<Self> {
        let columns = denoiser.columns_beyond(frame)?;
        let wrap = |image: &Image| wrap(image, columns);
        Ok(Self {
            color: wrap(frame.color)?,
            albedo: frame.albedo.map(wrap).transpose()?,
            normal: frame.normal.map(wrap).transpose()?,
            layers: frame.layers.iter().map(|layer| wrap(layer)).collect::<Result<_>>()?,
            input_scale: frame.input_scale,
            columns,
        })
    }

    /// The extended frame, without layers.
    pub(crate) fn frame(&self) -> Frame<'_> {
        let images = Frame::new(&self.color).albedo(self.albedo.as_ref());
        images.normal(self.normal.as_ref()).input_scale(self.input_scale)
    }

    /// The extended layers.
    pub(crate) fn layers(&self) -> Vec<&Image> {
        self.layers.iter().collect()
    }

    /// Extends an image of the panorama's size by the same columns.
    pub(crate) fn wrap(&self, image: &Image) -> Result<Image> {
        wrap(image, self.columns)
    }

    /// Crops denoised images of the extended size to the panorama's.
    pub(crate) fn unwrap(&self, wrapped: &Denoised) -> Result<Denoised> {
        let layers =
            wrapped.layers.iter().map(|layer| self.middle(layer)).collect::<Result<_>>()?;
        Ok(Denoised { color: self.middle(&wrapped.color)?, layers, alpha: None })
    }

    /// The step with its tile in the panorama's own coordinates.
    pub(crate) fn unwrap_step<'a>(&self, step: Progress<'a>) -> Progress<'a> {
        let width = self.color.width() - 2 * self.columns;
        Progress { tile: step.tile.and_then(|tile| tile.cropped(self.columns, width)), ..step }
    }

    fn middle(&self, image: &Image) -> Result<Image> {
        let columns = self.columns as usize..(image.width() - self.columns) as usize;
        let rows = (0..image.height()).flat_map(|y| &image.row(y)[columns.clone()]);
        let pixels = rows.copied().collect();
        Image::new(image.width() - 2 * self.columns, image.height(), pixels)
    }
}

fn wrap(image: &Image, columns: u32) -> Result<Image> {
    let mut wrapped = Image::filled(image.width() + 2 * columns, image.height(), [0.0; 3])?;
    let (width, columns) = (image.width() as usize, columns as usize);
    let from = |x: usize| (x + width * columns - columns) % width;
    for (y, row) in (0..).zip(wrapped.pixels_mut().chunks_exact_mut(width + 2 * columns)) {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = image.row(y)[from(x)];
        }
    }
    Ok(wrapped)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_repeat_beyond_both_edges_as_often_as_needed() {
        let pixels = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|v| [v; 3]);
        let image = Image::new(3, 2, pixels.to_vec()).unwrap();
        let found = wrap(&image, 4).unwrap();
        let row: Vec<_> = found.row(1).iter().map(|pixel| pixel[0]).collect();
        assert_eq!(row, [6.0, 4.0, 5.0, 6.0, 4.0, 5.0, 6.0, 4.0, 5.0, 6.0, 4.0]);
    }
}
