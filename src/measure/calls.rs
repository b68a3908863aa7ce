//! The time of each kernel call of a tile, except the exposure, which is measured once per frame.

use std::time::Instant;

use super::statistics::median;
use crate::denoiser::Denoiser;
use crate::denoiser::frame::Frame;
use crate::error::{Error, Result};
use crate::gpu::kernel::Context;
use crate::gpu::wait::{read, wait};
use crate::network::call::Call;

/// The cost of one kernel call, summed over the tiles of a frame.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct CallProfile {
    /// The layer's name, such as `enc_conv0a`, the operator's name, or both if one kernel does
    /// both, as in `dec_conv0b+kernel_conv0`.
    pub name: String,
    /// Multiply-accumulates of the layer, tile overlap included, whether skipped or not.
    pub macs: f64,
    /// Bytes of tensors and images read and written, each counted once.
    pub bytes: f64,
    /// Seconds of each run, shortest first.
    pub seconds: Vec<f64>,
}

impl CallProfile {
    /// The median run, in seconds.
    #[must_use]
    pub fn median(&self) -> f64 {
        median(&self.seconds)
    }

    /// Adds the call of one tile to the sums of one run.
    fn add(&mut self, call: &Call, seconds: f64) {
        self.name.clone_from(&call.name);
        self.macs += call.macs;
        self.bytes += call.bytes;
        self.seconds = vec![seconds + self.seconds.iter().sum::<f64>()];
    }
}

impl Denoiser {
    /// Denoises a frame once to warm up and then `runs` times (at least once), with each kernel
    /// call in its own submission. Times come from adapter timestamps around the call, or from the
    /// wall clock on CPU drivers.
    ///
    /// # Errors
    /// Fails like [`denoise`](Self::denoise), and on a GPU if the device was created without the
    /// feature `TIMESTAMP_QUERY`.
    pub fn profile(&self, frame: &Frame<'_>, runs: u32) -> Result<Vec<CallProfile>> {
        let clock = Clock::new(&self.context)?;
        self.profile_once(frame, &clock)?;
        let mut profile = self.profile_once(frame, &clock)?;
        for _ in 1..runs {
            let run = self.profile_once(frame, &clock)?;
            profile.iter_mut().zip(run).for_each(|(row, run)| row.seconds.extend(run.seconds));
        }
        for row in &mut profile {
            row.seconds.sort_by(f64::total_cmp);
        }
        Ok(profile)
    }

    /// One run, summed over the tiles.
    fn profile_once(&self, frame: &Frame<'_>, clock: &Clock) -> Result<Vec<CallProfile>> {
        let mut profile: Vec<CallProfile> = Vec::new();
        self.denoise_by(frame, &mut |_| {}, &mut |tile, _| {
            profile.resize_with(tile.calls().len(), CallProfile::default);
            for (row, call) in profile.iter_mut().zip(tile.calls()) {
                let time = || clock.time(&self.context, call);
                row.add(call, self.context.catch(time)?);
            }
            Ok(())
        })?;
        Ok(profile)
    }
}

/// How a submission is timed.
enum Clock {
    /// The wall clock: on a CPU driver a call takes milliseconds, and lavapipe writes timestamps
    /// before its threads are done.
    Wall,
    /// Adapter timestamps at both ends of a compute pass.
    Adapter(Box<Timestamps>),
}

struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
}

const BYTES: u64 = 2 * size_of::<u64>() as u64;

impl Clock {
    fn new(context: &Context) -> Result<Self> {
        let device = &context.device;
        if device.adapter_info().device_type == wgpu::DeviceType::Cpu {
            return Ok(Self::Wall);
        }
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Err(Error::Unsupported(format!(
                "{} was opened without the feature TIMESTAMP_QUERY, which a profile needs",
                device.adapter_info().name
            )));
        }
        Ok(Self::Adapter(Box::new(Timestamps::new(device))))
    }

    /// Seconds taken by the call.
    fn time(&self, context: &Context, call: &Call) -> Result<f64> {
        match self {
            Self::Wall => {
                let begin = Instant::now();
                submit(context, call, None, |_| {});
                wait(context)?;
                Ok(begin.elapsed().as_secs_f64())
            }
            Self::Adapter(timestamps) => timestamps.time(context, call),
        }
    }
}

impl Timestamps {
    fn new(device: &wgpu::Device) -> Self {
        let buffer = |usage| {
            let label = Some("timestamps");
            let descriptor =
                wgpu::BufferDescriptor { label, size: BYTES, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timestamps"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readback = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        Self { queries, resolved, readback }
    }

    fn time(&self, context: &Context, call: &Call) -> Result<f64> {
        let writes = wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        };
        submit(context, call, Some(writes), |encoder| {
            encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, BYTES);
        });
        let [begin, end]: [u64; 2] = read(context, &self.readback, bytemuck::pod_read_unaligned)?;
        let nanoseconds = f64::from(context.queue.get_timestamp_period());
        Ok(end.saturating_sub(begin) as f64 * nanoseconds * 1e-9)
    }
}

/// Submits a compute pass with this one call, followed by what `after` records.
fn submit(
    context: &Context,
    call: &Call,
    timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    after: impl FnOnce(&mut wgpu::CommandEncoder),
) {
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let label = Some(call.name.as_str());
    let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
    call.record_at(&mut encoder.begin_compute_pass(&descriptor), 0);
    after(&mut encoder);
    context.queue.submit([encoder.finish()]);
}
