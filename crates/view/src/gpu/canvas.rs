//! The texture that displays a result.

use wgdenoise::{FinishedTile, Image};

use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;

/// A texture on the window's device, being filled with a result.
pub(crate) enum Canvas<'a> {
    /// Filled tile by tile, without leaving the GPU.
    Tiles(&'a Gpu, Texture),
    /// Filled at once when the frame is complete.
    Whole(&'a Gpu),
}

impl<'a> Canvas<'a> {
    /// Creates a canvas for the tiles of `denoiser`. It waits for the whole frame if `denoiser`
    /// uses another device, whose tiles the window cannot read, or if the frame `is_settled_later`,
    /// because its tiles do not hold the final color.
    ///
    /// # Errors
    /// Same as [`Texture::new`].
    pub(crate) fn new(
        window: &'a Gpu,
        denoiser: &Gpu,
        size: [u32; 2],
        is_settled_later: bool,
    ) -> Result<Self, String> {
        if window.device != denoiser.device || is_settled_later {
            return Ok(Self::Whole(window));
        }
        Ok(Self::Tiles(window, Texture::new(window, size)?))
    }

    pub(crate) fn add(&self, tile: FinishedTile<'_>) {
        if let Self::Tiles(gpu, texture) = self {
            texture.place(gpu, &tile.into());
        }
    }

    /// Returns the texture of the whole result.
    ///
    /// # Errors
    /// Same as [`Texture::upload`].
    pub(crate) fn finish(self, result: &Image) -> Result<Texture, String> {
        match self {
            Self::Tiles(gpu, texture) => {
                texture.finish(gpu);
                Ok(texture)
            }
            Self::Whole(gpu) => Texture::upload(gpu, result),
        }
    }
}

#[cfg(test)]
mod tests {
    use wgdenoise::{Denoiser, Frame, Options, Progress, Quality, Weights, wgpu};

    use super::*;

    /// The texels of a result, filled by tiles or at once.
    fn shown(gpu: &Gpu, image: &Image, at_once: bool) -> Vec<[f32; 4]> {
        let weights = Weights::builtin(Quality::Fast).unwrap();
        let options = Options::default().tile(288);
        let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &weights, &options).unwrap();
        let canvas = Canvas::new(gpu, gpu, image.size().into(), at_once).unwrap();
        assert_eq!(matches!(canvas, Canvas::Whole(_)), at_once);
        let mut add = |step: Progress<'_>| step.tile.into_iter().for_each(|tile| canvas.add(tile));
        let found = denoiser.denoise_layers(&Frame::new(image), &mut add).unwrap();
        let texture = canvas.finish(&found.color).unwrap();
        (0..2).flat_map(|level| texture.read(gpu, level)).collect()
    }

    #[test]
    fn tiles_show_what_the_whole_result_shows() {
        let gpu = Gpu::for_tests();
        let pixel = |i: u32| [0, 1, 2].map(|c| ((i * 7919 + c * 31) % 256) as f32 / 256.0);
        let image = Image::new(301, 330, (0..301 * 330).map(pixel).collect()).unwrap();
        assert!(shown(&gpu, &image, false) == shown(&gpu, &image, true));
    }

    #[test]
    fn a_cpu_driver_denoises_on_a_device_of_its_own_whose_tiles_are_not_read() {
        let window = Gpu::for_tests();
        let canvas = Canvas::new(&window, &window.for_denoiser(), [8, 8], false).unwrap();
        let is_cpu = window.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        assert_eq!(matches!(canvas, Canvas::Whole(_)), is_cpu);
    }
}
