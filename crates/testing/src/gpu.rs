//! Runs single operators on the adapter of this machine. No adapter is a failure.

use std::sync::OnceLock;

use wgdenoise::Factor;
use wgdenoise::internals::gpu::kernel::Context;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::ops::channel_map::ChannelMap;
use wgdenoise::internals::reference::Tensor;
use wgdenoise::{Gpu, KernelSet, MatrixShape, Precision, wgpu};
use wgpu::util::DeviceExt as _;

use super::Tolerance;

/// The kernel sets that run on this adapter. On lavapipe, these are all sets, except `Matrix` if it
/// reports no matrices, as before Mesa 25.
pub fn kernel_sets(precision: Precision) -> Vec<KernelSet> {
    let gpu = gpu();
    let mut all = vec![KernelSet::Plain, KernelSet::Tiled, KernelSet::Wide];
    all.extend([KernelSet::Half, KernelSet::Simd]);
    all.extend(MatrixShape::of(&gpu.adapter, precision).map(KernelSet::Matrix));
    let found: Vec<_> = all.into_iter().filter(|set| set.runs_on(&gpu.device)).collect();
    let lavapipe = gpu.info.name.contains("256 bits");
    let matrices = gpu.adapter.cooperative_matrix_properties();
    let matrices = matrices.iter().any(|p| p.cr_type == wgpu::CooperativeScalarType::F32);
    // The matrix kernels need a fixed subgroup size.
    let usable = matrices && gpu.info.subgroup_min_size == gpu.info.subgroup_max_size;
    let expected = 3 + usize::from(has_halves()) + usize::from(lavapipe) + usize::from(usable);
    assert_eq!(found.len(), expected, "{found:?} on {}", gpu.info.name);
    found
}

/// Whether the adapter supports 16-bit float arithmetic, which `Half` needs.
pub fn has_halves() -> bool {
    gpu().adapter.features().contains(wgpu::Features::SHADER_F16)
}

/// The kernel sets that run the network with fused operators.
pub fn fused_sets(precision: Precision) -> Vec<KernelSet> {
    kernel_sets(precision).into_iter().filter(|&set| set != KernelSet::Plain).collect()
}

/// All combinations of kernel set and precision that run here.
pub fn variants() -> Vec<(KernelSet, Precision)> {
    variants_of(kernel_sets)
}

/// Rounds factors to 16-bit floats if the kernel set multiplies those.
pub fn factors(kernels: KernelSet, values: &[f32]) -> Vec<f32> {
    let half = |v: &f32| half::f16::from_f32(*v).to_f32();
    match kernels {
        KernelSet::Half | KernelSet::Matrix(MatrixShape { factor: Factor::F16, .. }) => {
            values.iter().map(half).collect()
        }
        _ => values.to_vec(),
    }
}

/// Combines the kernel sets of each precision with it.
pub fn variants_of(sets: fn(Precision) -> Vec<KernelSet>) -> Vec<(KernelSet, Precision)> {
    let of = |precision| sets(precision).into_iter().map(move |set| (set, precision));
    PRECISIONS.into_iter().flat_map(of).collect()
}

/// Both tensor precisions.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F16];

/// Rounding error of a sum of `terms` products of values in `[−1, 1]`. Partial sums grow like
/// `√terms/3`, and so does the random walk of their roundings by half a unit `u`: `terms/3 · u` on
/// average. Twelve times that covers the worst of a few million values.
pub fn sum_tolerance(terms: usize, precision: Precision) -> Tolerance {
    let absolute = 4.0 * terms.max(4) as f32 * f32::EPSILON / 2.0;
    match precision {
        Precision::F32 => Tolerance { absolute, relative: 0.0 },
        // A store rounds by 2⁻¹¹ of the value; one more bit covers sums on a rounding boundary.
        Precision::F16 => Tolerance { absolute, relative: 1.0 / 1024.0 },
    }
}

/// Rounding error of a convolution's sum of `terms` products, as in [`sum_tolerance`], by the
/// kernels of a set. `Half` adds chunks of `c` = 36 products in 16 bits: rounding each sum to the
/// nearest value is off by `u/√3` of it, `u` = 2⁻¹¹. The few weights of a chunk may all be near ±1,
/// so its sums grow like `√(k/3)`, which adds up to `u/√3 · √(c · terms/6)` over all chunks. Seven
/// times that, about `u · √(3 c · terms)`, covers the worst of a few million values.
pub fn convolution_tolerance(
    terms: usize,
    (kernels, precision): (KernelSet, Precision),
) -> Tolerance {
    let sum = sum_tolerance(terms, precision);
    let chunk = (3 * 36.min(terms) * terms) as f32;
    let in_chunks = if kernels == KernelSet::Half { chunk.sqrt() / 2048.0 } else { 0.0 };
    Tolerance { absolute: sum.absolute + in_chunks, ..sum }
}

/// The device under test, opened once.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(None).expect("the tests need an adapter"))
}

/// The context shared by all tests of one precision, so that each kernel is compiled once.
pub fn context(precision: Precision) -> &'static Context {
    static CONTEXTS: [OnceLock<Context>; 2] = [OnceLock::new(), OnceLock::new()];
    let index = usize::from(precision == Precision::F16);
    CONTEXTS[index].get_or_init(|| Context::new(&gpu().device, &gpu().queue, precision))
}

/// Rounds a tensor to this precision.
pub fn stored(tensor: &Tensor, precision: Precision) -> Tensor {
    let round = |&v: &f32| match precision {
        Precision::F32 => v,
        Precision::F16 => half::f16::from_f32(v).to_f32(),
    };
    Tensor { data: tensor.data.iter().map(round).collect(), ..*tensor }
}

/// Records and submits a compute pass.
pub fn submit(context: &Context, record: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
    let mut encoder = context.device.create_command_encoder(&Default::default());
    record(&mut encoder.begin_compute_pass(&Default::default()));
    context.queue.submit([encoder.finish()]);
}

/// Uploads a tensor; padding channels are 0.
pub fn upload(context: &Context, tensor: &Tensor, map: &ChannelMap) -> GpuTensor {
    let (width, height, quads) = (tensor.width, tensor.height, map.len() / 4);
    let mut texels = vec![0.0_f32; map.len() * width * height];
    for (stored, channel) in map.iter().enumerate() {
        let Some(channel) = *channel else { continue };
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            texels[texel(stored, [height, width], y, x)] = tensor.at(channel, y, x);
        }
    }
    let texture = GpuTensor::texture(context, [width as u32, height as u32], quads as u32);
    let layout = copy_layout(context, texture.width(), texture.height());
    let bytes = encode(&texels, context.precision);
    context.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
    GpuTensor::of(&texture, 0, quads as u32)
}

/// Reads back a tensor that fills its texture.
pub fn download(context: &Context, tensor: &GpuTensor, map: &ChannelMap) -> Tensor {
    let texture = tensor.view.texture();
    let row = (u64::from(tensor.width) * context.precision.texel_bytes()).next_multiple_of(256);
    let (height, width) = (tensor.height as usize, tensor.width as usize);
    let size = row * u64::from(tensor.height * tensor.quads);
    let bytes = read_back(context, size, |encoder, buffer| {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row as u32),
            rows_per_image: Some(tensor.height),
        };
        let target = wgpu::TexelCopyBufferInfo { buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
    });
    let kept = width * context.precision.texel_bytes() as usize;
    let rows = bytes.chunks_exact(row as usize).flat_map(|row| &row[..kept]).copied();
    let texels = decode(&rows.collect::<Vec<_>>(), context.precision);
    let place = |c| map.iter().position(|m| *m == Some(c)).expect("every channel is stored");
    Tensor::from_fn(map.iter().flatten().count(), height, width, |c, y, x| {
        texels[texel(place(c), [height, width], y, x)]
    })
}

/// Creates a buffer with every usage that a kernel or a copy may need.
pub fn buffer(context: &Context, contents: &[u8]) -> wgpu::Buffer {
    context.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST,
    })
}

/// Reads the contents of a fresh buffer after a copy into it.
pub fn read_back(
    context: &Context,
    size: u64,
    copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
) -> Vec<u8> {
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = context.device.create_command_encoder(&Default::default());
    copy(&mut encoder, &buffer);
    context.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    context.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device works");
    buffer.slice(..).get_mapped_range().expect("the buffer is mapped").to_vec()
}

fn texel(stored: usize, [height, width]: [usize; 2], y: usize, x: usize) -> usize {
    ((stored / 4 * height + y) * width + x) * 4 + stored % 4
}

fn copy_layout(context: &Context, width: u32, height: u32) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(width * context.precision.texel_bytes() as u32),
        rows_per_image: Some(height),
    }
}

fn encode(values: &[f32], precision: Precision) -> Vec<u8> {
    match precision {
        Precision::F32 => bytemuck::cast_slice(values).to_vec(),
        Precision::F16 => {
            values.iter().flat_map(|&v| half::f16::from_f32(v).to_le_bytes()).collect()
        }
    }
}

fn decode(bytes: &[u8], precision: Precision) -> Vec<f32> {
    match precision {
        Precision::F32 => bytemuck::pod_collect_to_vec(bytes),
        Precision::F16 => {
            let halves: Vec<half::f16> = bytemuck::pod_collect_to_vec(bytes);
            halves.into_iter().map(half::f16::to_f32).collect()
        }
    }
}
