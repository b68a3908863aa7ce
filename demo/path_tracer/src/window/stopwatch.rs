//! Times the parts of a frame on the GPU.

use std::time::{Duration, Instant};

use path_tracer::renderer::Result;

/// The times of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Times {
    /// Path tracer and denoiser, by the GPU's clock.
    Parts { render: Duration, denoise: Duration },
    /// The whole submission by the CPU's clock, where the adapter has no reliable one.
    Whole(Duration),
}

/// Measures one frame at a time.
pub(super) struct Stopwatch {
    queries: Option<Queries>,
    begin: Instant,
}

struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    /// Nanoseconds per tick.
    period: f32,
}

/// The timestamps: start and end of the path tracer's pass, and start of the display pass. The
/// denoiser runs between the last two.
const TICKS: u32 = 3;
const BYTES: u64 = TICKS as u64 * size_of::<u64>() as u64;

impl Stopwatch {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        // CPU drivers write timestamps before their threads have finished.
        let is_gpu = device.adapter_info().device_type != wgpu::DeviceType::Cpu;
        let timestamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries =
            (is_gpu && timestamps).then(|| Queries::new(device, queue.get_timestamp_period()));
        Self { queries, begin: Instant::now() }
    }

    /// Call before recording a frame.
    pub(super) fn start(&mut self) {
        self.begin = Instant::now();
    }

    /// Timestamps for the path tracer's pass.
    pub(super) fn render(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.queries.as_ref().map(|queries| wgpu::ComputePassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Timestamp for the display pass.
    pub(super) fn present(&self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.queries.as_ref().map(|queries| wgpu::RenderPassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: Some(2),
            end_of_pass_write_index: None,
        })
    }

    /// Copies the timestamps; record it last.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(Queries { set, resolved, readable, .. }) = &self.queries {
            encoder.resolve_query_set(set, 0..TICKS, resolved, 0);
            encoder.copy_buffer_to_buffer(resolved, 0, readable, 0, BYTES);
        }
    }

    /// Waits for the submitted frame, because queued frames would only make the camera lag.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn stop(&self, device: &wgpu::Device) -> Result<Times> {
        let Some(queries) = &self.queries else {
            device.poll(wgpu::PollType::wait_indefinitely())?;
            return Ok(Times::Whole(self.begin.elapsed()));
        };
        queries.readable.map_async(wgpu::MapMode::Read, .., |_| {});
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let times = queries.times()?;
        queries.readable.unmap();
        Ok(times)
    }
}

impl Queries {
    fn new(device: &wgpu::Device, period: f32) -> Self {
        let set = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("frame times"),
            ty: wgpu::QueryType::Timestamp,
            count: TICKS,
        });
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame times"),
                size: BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        Self { set, resolved, readable, period }
    }

    /// Reads the mapped buffer.
    fn times(&self) -> Result<Times> {
        let bytes = self.readable.get_mapped_range(..)?;
        let ticks = bytes.chunks_exact(size_of::<u64>());
        let ticks: Vec<u64> = ticks.map(bytemuck::pod_read_unaligned).collect();
        let between = |from: usize, to: usize| {
            let ticks = ticks[to].saturating_sub(ticks[from]);
            Duration::from_secs_f64(ticks as f64 * f64::from(self.period) * 1e-9)
        };
        Ok(Times::Parts { render: between(0, 1), denoise: between(1, 2) })
    }
}
