//! GPU memory that a frame leaves for the next one.

use super::Denoiser;
use super::tile_buffers::{TileBuffers, TileShape};
use crate::error::Result;
use crate::network::compile::CompiledNetwork;

impl Denoiser {
    /// The last frame's buffers if they have this shape. Otherwise frees them and allocates new
    /// ones.
    pub(super) fn tile_buffers(
        &self,
        network: &CompiledNetwork,
        shape: TileShape,
    ) -> Result<TileBuffers> {
        let kept = self.kept.lock().expect("no thread panicked here").take();
        if let Some(kept) = kept.filter(|kept| kept.shape == shape) {
            return Ok(kept);
        }
        let (context, skip) = (&self.context, self.options.skip_clean);
        context.catch(|| Ok(TileBuffers::new(context, network, shape, skip)))
    }

    /// Frees the GPU memory that the last blocking call left for the next one, as
    /// [`Options::keep_memory`](crate::Options::keep_memory) describes. The next call allocates
    /// anew.
    ///
    /// # Panics
    /// Panics if another thread panicked in a blocking call.
    pub fn free_memory(&self) {
        *self.kept.lock().expect("no thread panicked here") = None;
    }

    /// Keeps a frame's buffers for the next one, unless the options forbid it.
    pub(super) fn keep(&self, buffers: TileBuffers) {
        if self.options.keep_memory {
            *self.kept.lock().expect("no thread panicked here") = Some(buffers);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Denoiser, Error, Frame, Gpu, Image, Options, Weights};

    fn denoiser(options: &Options) -> Denoiser {
        let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
        let weights = include_bytes!("../../tests/fixtures/kernel_tiny.safetensors");
        let weights = Weights::from_bytes(weights).expect("the fixture follows the format");
        Denoiser::new(&device, &queue, &weights, options).expect("the device works")
    }

    fn image(width: u32, height: u32) -> Image {
        Image::filled(width, height, [0.5; 3]).unwrap()
    }

    /// The output buffer that the denoiser keeps.
    fn kept(denoiser: &Denoiser) -> Option<wgpu::Buffer> {
        denoiser.kept.lock().unwrap().as_ref().map(|buffers| buffers.output.clone())
    }

    #[test]
    fn a_frame_of_the_same_shape_reuses_the_memory_and_any_other_replaces_it() {
        let denoiser = denoiser(&Options::default());
        let (small, large) = (image(40, 30), image(80, 30));
        let small = Frame::new(&small);
        let buffer_after = |frame: &Frame<'_>| {
            denoiser.denoise_layers(frame, &mut |_| {}).unwrap();
            kept(&denoiser).expect("the frame's buffers are kept")
        };
        let first = buffer_after(&small);
        assert_eq!(buffer_after(&small), first);
        let shapes = [
            buffer_after(&Frame::new(&large)),
            buffer_after(&small),
            buffer_after(&small.albedo(small.color)),
            buffer_after(&small.layers(&[small.color])),
        ];
        let all = [&[first], &shapes[..]].concat();
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "each differs from the one before");
    }

    #[test]
    fn nothing_is_kept_after_a_failure_or_if_the_options_forbid_it() {
        let image = image(40, 30);
        let frame = Frame::new(&image);
        let denoiser_that_keeps = denoiser(&Options::default());
        denoiser_that_keeps.denoise(&frame).unwrap();
        let end_with = |error: fn() -> Error| {
            let mut fail = |_: &_, _: &mut dyn FnMut(usize) -> _| Err(error());
            denoiser_that_keeps.denoise_by(&frame, &mut |_| {}, &mut fail).unwrap_err();
            kept(&denoiser_that_keeps)
        };
        assert!(end_with(|| Error::Stopped).is_some(), "a stopped frame has not failed");
        assert!(end_with(|| Error::weights("none")).is_none());

        denoiser_that_keeps.denoise(&frame).unwrap();
        denoiser_that_keeps.free_memory();
        assert!(kept(&denoiser_that_keeps).is_none());

        let denoiser_that_frees = denoiser(&Options::default().keep_memory(false));
        denoiser_that_frees.denoise(&frame).unwrap();
        assert!(kept(&denoiser_that_frees).is_none());
    }
}
