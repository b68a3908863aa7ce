//! Compares the bytes and operations of a frame, counted from the compiled calls, with arithmetic
//! by hand and with the tables of `docs/performance.md`.

use super::bind::{Bound, TileCalls};
use super::compile::CompiledNetwork;
use crate::gpu::device::Gpu;
use crate::gpu::kernel::Context;
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::matrix_shape::{Factor, MatrixShape};
use crate::gpu::precision::Precision;
use crate::model::{Quality, Weights};
use crate::ops::input_process::Sources;
use crate::ops::tile::Tile;

const DOCUMENTED: &str = include_str!("../../docs/performance.md");

const TIERS: [(&str, Quality); 3] =
    [("fast", Quality::Fast), ("balanced", Quality::Balanced), ("high", Quality::High)];

const MATRIX: KernelSet =
    KernelSet::Matrix(MatrixShape { side: 16, factor: Factor::F16, lanes: 32 });
const SETS: [(&str, KernelSet); 2] = [("tiled", KernelSet::Tiled), ("matrix", MATRIX)];

/// A tile whose side every level halves without remainder.
const SIDE: u32 = 64;
const PIXELS: f64 = (SIDE * SIDE) as f64;

/// Name, then multiply-accumulates and bytes per pixel of the image.
type Counted = (String, f64, f64);

/// The calls of a frame with albedo and normal, three 32-bit floats a pixel, and 16-bit tensors.
fn calls(device: &Gpu, kernels: KernelSet, quality: Quality) -> Vec<Counted> {
    let context = Context::new(&device.device, &device.queue, Precision::F16);
    // Counting needs no valid kernel, so a device without matrices will do.
    let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let weights = Weights::builtin(quality).expect("they are built in");
    let network = CompiledNetwork::new(&context, kernels, &weights).expect("it fits");
    let calls = bound(&context, &network);
    drop(pollster::block_on(scope.pop()));
    let calls = calls.calls().iter();
    calls.map(|call| (call.name.clone(), call.macs / PIXELS, call.bytes / PIXELS)).collect()
}

fn bound(context: &Context, network: &CompiledNetwork) -> TileCalls {
    let buffer = |size: u64, usage| {
        context.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let image = buffer(u64::from(SIDE * SIDE) * 12, wgpu::BufferUsages::STORAGE);
    let output = buffer(u64::from(SIDE * SIDE) * 12, wgpu::BufferUsages::STORAGE);
    let tiles = buffer(size_of::<Tile>() as u64, wgpu::BufferUsages::UNIFORM);
    let blend = buffer(4, wgpu::BufferUsages::UNIFORM);
    let color = (&image).into();
    let sources = Sources {
        tiles: &tiles,
        color,
        albedo: Some(color),
        normal: Some(color),
        unorm_normal: false,
        input_scale: &buffer(4, wgpu::BufferUsages::STORAGE),
        encoding: network.encoding,
    };
    let (tile, output) = ([SIDE; 2], (&output).into());
    let bound = Bound { tile, sources, output, blend: &blend, skip_clean: true, layers: &[] };
    TileCalls::new(context, network, &bound)
}

fn gpu() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter")
}

/// `balanced` has 16 channels at full resolution (32 bytes per pixel), twice as many at half, and
/// 12 logits per level, of which the pyramid reads four. An image has 12 bytes per pixel, a pyramid
/// 32: color, weight and albedo.
#[test]
fn the_calls_at_full_resolution_move_what_was_calculated_by_hand() {
    let images = 3.0 * 12.0;
    let (logits, confidence, light) = (24.0, 8.0, 32.0);
    let beginning = [("enc_conv0b", 32.0 + 32.0 + 8.0), ("dec_conv0a", 32.0 + 64.0 / 4.0 + 32.0)];
    let coarser = |bytes: f64| bytes / 4.0;
    let ending = [
        ("pyramid1", 12.0 + 12.0 + confidence + coarser(confidence + light)),
        ("gather0", 12.0 + 12.0 + logits + coarser(light) + 12.0),
    ];
    let tiled = [("input+enc_conv0a", images + 32.0), ("dec_conv0b+kernel_conv0", 32.0 + logits)];
    let found = calls(&gpu(), KernelSet::Tiled, Quality::Balanced);
    for (name, expected) in beginning.into_iter().chain(ending).chain(tiled) {
        let (_, _, bytes) = found.iter().find(|call| call.0 == name).expect(name);
        assert_eq!(*bytes, expected, "{name}");
    }
}

/// Every row of the table of limits: counted, or calculated from what was counted.
#[test]
fn the_documented_limits_are_those_of_the_compiled_networks() {
    let gpu = gpu();
    let mut missing = Vec::new();
    for (tier, quality) in TIERS {
        for (set, kernels) in SETS {
            let row = row(tier, set, &calls(&gpu, kernels, quality));
            if !DOCUMENTED.lines().any(|line| line == row) {
                missing.push(row);
            }
        }
    }
    assert!(missing.is_empty(), "docs/performance.md lacks these rows:\n{}", missing.join("\n"));
}

/// 16-bit arithmetic reads and writes the same tensors, with as many products.
#[test]
fn the_half_kernels_do_the_work_of_the_tiled_ones() {
    let gpu = gpu();
    let [half, tiled] =
        [KernelSet::Half, KernelSet::Tiled].map(|kernels| calls(&gpu, kernels, Quality::Balanced));
    assert_eq!(half, tiled);
}

/// Formats a row of the table. Times count traffic or products alone, at the rates in the table's
/// header.
fn row(tier: &str, set: &str, calls: &[Counted]) -> String {
    let is_pyramid =
        |call: &Counted| ["pyramid", "gather"].iter().any(|name| call.0.starts_with(name));
    let sum = |of: fn(&Counted) -> f64| calls.iter().map(of).sum::<f64>();
    let (macs, bytes) = (sum(|call| call.1), sum(|call| call.2));
    let pyramid: f64 = calls.iter().filter(|call| is_pyramid(call)).map(|call| call.2).sum();
    let pixels = 3840.0 * 2160.0;
    let (traffic, products) = (bytes * pixels, 2.0 * macs * pixels);
    let milliseconds = |work: f64, rate: f64| format!("{:.1} ms", work / rate * 1e3);
    let moved = [448e9, 3350e9].map(|rate| milliseconds(traffic, rate)).join(" | ");
    let computed = match set {
        "matrix" => ["–".into(), "–".into(), milliseconds(products, 700e12)],
        _ => [milliseconds(products, 20e12), milliseconds(products, 60e12), "–".into()],
    };
    format!(
        "| {tier} | {set} | {} | {:.0} | {pyramid:.0} | {:.1} GB | {moved} | {:.1} | {:.2} TFLOP | {} |",
        calls.len(),
        bytes - pyramid,
        traffic / 1e9,
        macs / 1e3,
        products / 1e12,
        computed.join(" | ")
    )
}
