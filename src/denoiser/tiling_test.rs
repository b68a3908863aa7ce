//! Tile plans for random sizes and budgets.

use std::sync::Mutex;

use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::*;
use crate::{Gpu, Inputs, Options, Quality, Weights};

fn sizes() -> impl Strategy<Value = (u32, u32)> {
    let (long, short) = (1..=MAX_SIDE + 9, 1_u32..300);
    prop_oneof![(1_u32..2000, 1_u32..2000), (long.clone(), short.clone()), (short, long)]
}

/// From a few bytes to more than any machine has.
fn budgets() -> impl Strategy<Value = u64> {
    prop_oneof![(0_u32..40).prop_map(|bits| 3 << bits), 1_u64 << 22..1 << 28, any::<u64>()]
}

/// The blocking call's allocation for a tile, with a second copy of every image in transit.
fn allocated(denoiser: &Denoiser, tile: [u32; 2], width: u32, contents: Contents) -> u64 {
    let Contents { inputs, layers } = contents;
    let network = denoiser.network(inputs).unwrap();
    let image = u64::from(tile[0]) * u64::from(tile[1]) * PIXEL_BYTES;
    let color = image.max(16 * u64::from(width) * PIXEL_BYTES);
    let others = 1 + u64::from(inputs.albedo) + u64::from(inputs.normal) + u64::from(layers);
    network.bytes(tile, denoiser.precision().texel_bytes(), layers) + 2 * (color + others * image)
}

#[test]
fn no_plan_takes_more_memory_than_the_budget_and_every_refusal_says_why() {
    let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
    let weights = Weights::builtin(Quality::Fast).unwrap();
    let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default()).unwrap();
    let denoiser = Mutex::new(denoiser);
    let tiles = prop::option::of(prop_oneof![1_u32..1000, any::<u32>()]);
    let cases = (sizes(), budgets(), tiles, any::<[bool; 2]>());
    let check = |((width, height), budget, tile, [all, layers]): (_, _, Option<u32>, [bool; 2])| {
        let mut denoiser = denoiser.lock().unwrap();
        denoiser.options.memory_bytes = budget;
        denoiser.options.tile = tile;
        let inputs = if all { Inputs::ALL } else { Inputs::default() };
        let contents = Contents { inputs, layers };
        match denoiser.tile_plan(width, height, contents) {
            Ok(plan) => {
                let bytes = denoiser.memory_bytes(width, height, contents).unwrap();
                prop_assert!(bytes <= budget, "{} of {} bytes", bytes, budget);
                prop_assert_eq!(bytes, allocated(&denoiser, plan.tile, width, contents));
                let side = plan.tile[0].max(plan.tile[1]);
                prop_assert!(side <= tile.unwrap_or(u32::MAX), "{:?}", plan.tile);
            }
            Err(Error::Image(_)) => prop_assert!(width.max(height) > MAX_SIDE),
            Err(Error::Budget(text)) => prop_assert!(text.ends_with("raise that limit"), "{text}"),
            Err(other) => prop_assert!(false, "{other}"),
        }
        Ok(())
    };
    TestRunner::default().run(&cases, check).unwrap();
}

#[test]
fn no_buffer_is_larger_than_the_device_creates() {
    let Gpu { adapter, .. } = Gpu::open(None).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits { max_buffer_size: 2 << 20, ..adapter.limits() },
        ..Default::default()
    }))
    .unwrap();
    let weights = include_bytes!("../../tests/fixtures/kernel_tiny.safetensors");
    let weights = Weights::from_bytes(weights).unwrap();
    let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default()).unwrap();
    let image = crate::Image::filled(608, 400, [0.5; 3]).unwrap();
    denoiser.denoise(&Frame::new(&image)).unwrap();
}
