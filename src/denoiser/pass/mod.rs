//! A denoiser bound to one size and to images on the GPU, which a renderer records every frame.

mod accumulation;
mod bind;
mod descriptor;
mod formats;
mod held;
mod image;
mod schedule;

pub use self::descriptor::{InputScale, NormalEncoding, PassDescriptor, PassLayer};
pub use self::formats::{LayerFormats, PassFormats};
pub use self::image::PassImage;
pub use self::schedule::Schedule;

use self::accumulation::Accumulation;
use self::held::Rescue;
use crate::denoiser::Denoiser;
use crate::error::{Error, Result};
use crate::gpu::wait::wait;
use crate::network::bind::TileCalls;
use crate::ops::autoexposure::Autoexposure;
use crate::plan::memory::Footprint;

/// A denoising pass over images on the GPU. Recording it creates no resources and cannot fail.
///
/// It keeps the images alive and owns the network's tensors; per frame it reads and writes only the
/// images. A frame's work is one compute pass in the caller's submission, after copies of the
/// inputs that the output overwrites.
///
/// With [motion](PassDescriptor::motion) it also owns the history of the last frames, which each
/// frame reads and updates when it runs on the GPU. Frames follow each other in submission order; a
/// frame that is recorded but never submitted has no effect.
#[derive(Debug)]
pub struct Pass {
    rescues: Vec<Rescue>,
    exposure: Option<Autoexposure>,
    graph: TileCalls,
    /// Byte offset of each tile in the uniform buffer.
    tiles: Vec<u32>,
    accumulation: Option<Accumulation>,
    blend: wgpu::Buffer,
    /// The denoiser's queue.
    queue: wgpu::Queue,
}

impl Denoiser {
    /// Binds the denoiser to images. A new size or new images need a new pass; kernels and weights
    /// stay with the denoiser, so a further pass over the same formats compiles nothing. Inputs
    /// that the weights were not trained with are not read. All images must belong to the
    /// denoiser's `wgpu::Instance`: wgpu panics on objects of another, or confuses them.
    ///
    /// # Errors
    /// Fails if an image has the wrong size, an unsupported format, layout or usage, or another
    /// device; if the input scale is not a positive number; if the tensors exceed the memory budget
    /// or the adapter's memory, where a smaller [`Options::memory_bytes`] helps; or if the device
    /// is lost. The message tells you what to change.
    ///
    /// [`Options::memory_bytes`]: crate::Options::memory_bytes
    pub fn pass(&self, descriptor: &PassDescriptor<'_>) -> Result<Pass> {
        let trained = self.weights().metadata().inputs;
        let descriptor = PassDescriptor {
            albedo: descriptor.albedo.filter(|_| trained.albedo),
            normal: descriptor.normal.filter(|_| trained.normal),
            ..*descriptor
        };
        descriptor.check(&self.context.device.limits())?;
        descriptor.check_accumulation(&self.context.device.limits())?;
        if !descriptor.layers.is_empty() {
            self.check_layers()?;
        }
        // A lost device rejects images as if they belonged to another device.
        self.context.catch(|| Ok(()))?;
        let network = self.network(descriptor.inputs())?;
        // The images are the caller's, so they do not count against the budget.
        let picture = descriptor.accumulation_bytes();
        let footprint = Footprint { picture, ..Footprint::default() };
        let plan =
            self.plan(descriptor.size(), &network, footprint, !descriptor.layers.is_empty())?;
        let bind = || self.bind(&descriptor, &network, &plan);
        match bind() {
            Err(Error::OutOfMemory(_)) if self.kept.lock().is_ok_and(|kept| kept.is_some()) => {
                self.free_memory();
                // Buffers are freed once the adapter no longer uses them.
                wait(&self.context)?;
                bind()
            }
            bound => bound,
        }
    }
}

impl Pass {
    /// Records the whole pass: the exposure, then the network and the layers tile by tile, and with
    /// motion the averages of the color and each layer over the last frames.
    ///
    /// All of it lands in one of the caller's submissions, which keeps the adapter busy for as long
    /// as the network takes. At 3840×2160, `fast` needs 0.19 TFLOP, `balanced` 0.62 and `high` 1.3,
    /// plus the overlap of tiles: the same number of seconds on an adapter whose convolutions reach
    /// 1 TFLOP/s. Each dispatch is bounded ([`Options::tile`](crate::Options::tile) shortens them),
    /// but some drivers apply their watchdog, 2 s on Windows, to the whole submission. On those,
    /// use cheaper weights or fewer pixels, or [`Denoiser::denoise`], which submits in small parts.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        for rescue in &self.rescues {
            rescue.record(encoder);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("wgdenoise"),
            timestamp_writes: None,
        });
        if let Some(exposure) = &self.exposure {
            exposure.bins.record(&mut pass);
            exposure.reduce.record(&mut pass);
        }
        for &offset in &self.tiles {
            self.graph.record_at(&mut pass, offset);
        }
        let Some(accumulation) = &self.accumulation else { return };
        accumulation.record_at(&mut pass, self.tiles[0]);
        drop(pass);
        accumulation.advance(encoder);
    }

    /// Sets the share of noisy color in the output for later submissions, clamped to `[0, 1]`; NaN
    /// counts as 0, the share in a new pass. The less noise there is, the closer the built-in
    /// weights stay to the noisy color, but some bias remains. [`Schedule::blend`] returns a share
    /// that grows as samples accumulate, so that the image converges. Uses four bytes of wgpu's
    /// staging memory.
    pub fn set_blend(&self, share: f32) {
        let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        self.queue.write_buffer(&self.blend, 0, bytemuck::bytes_of(&share));
    }

    /// Sets the maximum number of past frames in the average, for later submissions: 8 in a new
    /// pass; 0 uses each frame alone. Negative numbers and NaN count as 0. Does nothing without
    /// motion. Uses four bytes of wgpu's staging memory.
    pub fn set_history(&self, frames: f32) {
        let frames = if frames.is_nan() { 0.0 } else { frames.max(0.0) };
        if let Some(accumulation) = &self.accumulation {
            accumulation.history.set_longest(&self.queue, frames);
        }
    }

    /// Restarts the average with the next submitted frame, as in a new pass: for cuts, camera jumps
    /// and new scenes. Does nothing without motion. Uses four bytes of wgpu's staging memory.
    pub fn reset_history(&self) {
        if let Some(accumulation) = &self.accumulation {
            accumulation.history.reset(&self.queue);
        }
    }
}
