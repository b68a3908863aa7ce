//! The denoiser bound to a size and to images on the GPU: what a renderer records per frame.

mod bind;
mod descriptor;
mod formats;
mod held;
mod image;
mod schedule;

pub use self::descriptor::{InputScale, NormalEncoding, PassDescriptor};
pub use self::formats::PassFormats;
pub use self::image::PassImage;
pub use self::schedule::Schedule;

use self::held::Rescue;
use crate::denoiser::Denoiser;
use crate::error::Result;
use crate::network::bind::TileCalls;
use crate::ops::autoexposure::Autoexposure;
use crate::plan::memory::Footprint;

/// A denoising pass over images on the GPU. Recording it creates nothing and cannot fail.
///
/// It holds on to the images. It owns the network's tensors and, per frame, reads and writes the
/// images alone. A frame's work becomes part of the caller's submission as one compute pass, after
/// the copies of inputs that the output overwrites.
#[derive(Debug)]
pub struct Pass {
    rescues: Vec<Rescue>,
    exposure: Option<Autoexposure>,
    graph: TileCalls,
    /// Offset of each tile in the uniform buffer, in bytes.
    tiles: Vec<u32>,
    blend: wgpu::Buffer,
    /// The denoiser's.
    queue: wgpu::Queue,
}

impl Denoiser {
    /// Binds the denoiser to images. Another size or other images are another pass; kernels and
    /// weights stay with the denoiser, so that making one for the same formats compiles nothing.
    /// Inputs that the weights were not trained with are not read. All images must be of one
    /// `wgpu::Instance`: wgpu panics at, or mixes up, objects of another.
    ///
    /// # Errors
    /// If an image has another size, a format, layout or usage that the kernels cannot take, or
    /// belongs to another device; if the input scale is no positive number; if the tensors do not fit
    /// the memory budget or the adapter's memory, where a smaller [`Options::memory_bytes`] helps; or
    /// if the device is lost. The message says what to change.
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
        // A lost device refuses images as if they were another's.
        self.context.catch(|| Ok(()))?;
        let network = self.network(descriptor.inputs())?;
        // The images are the caller's.
        let plan = self.plan(descriptor.size(), &network, Footprint::default())?;
        self.bind(&descriptor, &network, &plan)
    }
}

impl Pass {
    /// Records the whole pass: exposure, then tile by tile the network. All of it becomes part of one
    /// submission of the caller's, as long as the network takes for the frame: at 3840×2160 `fast`
    /// has 0.19 TFLOP, `balanced` 0.73 and `high` 1.9, before the overlap of tiles, so that an
    /// adapter on which the convolutions reach 1 TFLOP/s is busy for as many seconds. Each dispatch
    /// is bounded ([`Options::tile`](crate::Options::tile) makes them shorter), but a driver that
    /// holds a whole submission against its watchdog, 2 s on Windows, counts their sum: there, take
    /// cheaper weights or fewer pixels, or [`Denoiser::denoise`], which submits in small parts.
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
    }

    /// Sets the share of the noisy colour in the output for what is submitted from now on: from 0,
    /// as it is in a new pass and as NaN counts, to 1; what lies beyond is clamped.
    /// [`Schedule::blend`] has a share that grows as samples accumulate, so that no bias stays.
    /// Takes wgpu's staging memory for four bytes.
    pub fn set_blend(&self, share: f32) {
        let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        self.queue.write_buffer(&self.blend, 0, bytemuck::bytes_of(&share));
    }
}
