//! Tiles that shrink, stops and progress of the blocking call.

use std::sync::atomic::{AtomicBool, Ordering};

use super::*;
use crate::{Gpu, Inputs, Options, Weights};

fn denoiser() -> Denoiser {
    let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
    let weights = include_bytes!("../../tests/fixtures/unet_tiny.safetensors");
    let weights = Weights::from_bytes(weights).expect("the fixture follows the format");
    Denoiser::new(&device, &queue, &weights, &Options::default()).expect("the device works")
}

/// Denoises, but reports out of memory after the network ran on a tile of more than `most`
/// pixels.
fn denoise(denoiser: &Denoiser, most: u32) -> Result<Image> {
    let pixel = |i: u32| [0, 1, 2].map(|c| ((i * 7919 + c * 31) % 256) as f32 / 256.0);
    let color = Image::new(300, 200, (0..300 * 200).map(pixel).collect())?;
    denoiser
        .denoise_by(&Frame::new(&color), &mut |_| {}, &mut |tile, progress| {
            tile.run(progress)?;
            if tile.rows_of(1) > most { Err(Error::OutOfMemory("none".into())) } else { Ok(()) }
        })
        .map(|denoised| denoised.color)
}

#[test]
fn tiles_are_halved_until_they_fit_and_stay_so() {
    let denoiser = denoiser();
    let whole = denoise(&denoiser, u32::MAX).unwrap();
    assert_eq!(denoiser.take_notices(), [""; 0]);
    assert_eq!(denoise(&denoiser, 20_000).unwrap(), whole);
    let notices = denoiser.take_notices();
    assert!(notices.len() == 2 && notices[0].contains("tiles of 304×208 pixels"), "{notices:?}");
    let [width, height] = denoiser.tile_plan(300, 200, Inputs::default()).unwrap().tile;
    assert!(width * height <= 20_000, "{width}×{height}");
    assert_eq!(denoise(&denoiser, 20_000).unwrap(), whole);
    assert_eq!(denoiser.take_notices(), [""; 0]);
}

#[test]
fn the_smallest_tile_is_the_end_and_the_next_frame_is_tried_again() {
    let denoiser = denoiser();
    let error = denoise(&denoiser, 0).unwrap_err().to_string();
    let network = denoiser.network(Inputs::default()).unwrap();
    let side = 2 * network.halo + network.alignment;
    assert!(error.contains(&format!("even with tiles of {side}×{side} pixels")), "{error}");
    assert!(denoiser.take_notices().len() > 2);
    denoise(&denoiser, u32::MAX).unwrap();
}

#[test]
fn a_frame_stops_when_its_flag_is_set_and_the_next_one_is_whole() {
    let denoiser = denoiser();
    let color = Image::filled(300, 200, [0.5; 3]).unwrap();
    let stop = AtomicBool::new(false);
    let frame = Frame::new(&color).stop(&stop);
    let mut finished = false;
    let stopped = denoiser.denoise_by(
        &frame,
        &mut |_| stop.store(true, Ordering::Relaxed),
        &mut |tile, progress| {
            progress(1)?;
            finished = true;
            tile.run(progress)
        },
    );
    assert!(matches!(stopped, Err(Error::Stopped)) && !finished);
    assert!(matches!(denoiser.denoise(&frame), Err(Error::Stopped)), "before the first tile");
    denoiser.denoise(&frame.stop(None)).unwrap();
}

#[test]
fn a_stopped_frame_leaves_its_memory_and_kernels_to_the_next_one() {
    let denoiser = denoiser();
    let color = Image::filled(300, 200, [0.5; 3]).unwrap();
    denoiser.denoise(&Frame::new(&color)).unwrap();
    let compiled = denoiser.context.compiled();
    let stop = AtomicBool::new(false);
    let stopped = denoiser.denoise_with_progress(&Frame::new(&color).stop(&stop), &mut |_, _| {
        stop.store(true, Ordering::Relaxed);
    });
    assert!(matches!(stopped, Err(Error::Stopped)));
    assert_eq!(denoiser.context.compiled(), compiled);
    assert!(denoiser.kept.lock().unwrap().is_some());
}

#[test]
fn a_frame_stops_between_its_layers() {
    let weights = include_bytes!("../../tests/fixtures/kernel_tiny.safetensors");
    let weights = Weights::from_bytes(weights).expect("the fixture follows the format");
    let Gpu { device, queue, .. } = Gpu::open(None).expect("the tests need an adapter");
    let denoiser = Denoiser::new(&device, &queue, &weights, &Options::default()).unwrap();
    let color = Image::filled(40, 30, [0.5; 3]).unwrap();
    let stop = AtomicBool::new(false);
    let (mut is_ready, mut layers) = (false, 0);
    let stopped = denoiser.denoise_layers(
        &Frame::new(&color).layers(&[&color; 3]).stop(&stop),
        &mut |step| {
            layers += usize::from(is_ready);
            stop.store(layers == 1, Ordering::Relaxed);
            is_ready |= step.tile.is_some();
        },
    );
    assert!(matches!(stopped, Err(Error::Stopped)) && layers == 1);
}

#[test]
fn progress_rises_call_by_call_over_all_tiles_to_the_total() {
    let denoiser = denoiser();
    let color = Image::filled(300, 200, [0.5; 3]).unwrap();
    let mut steps = Vec::new();
    denoiser
        .denoise_with_progress(&Frame::new(&color), &mut |done, of| steps.push((done, of)))
        .unwrap();
    let total = steps[0].1;
    assert!(steps.is_sorted() && steps.iter().all(|step| step.1 == total), "{steps:?}");
    assert_eq!(steps.last(), Some(&(total, total)));
    assert!(total > 10, "{total} calls in a network of 14 layers");
}
