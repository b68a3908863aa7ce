//! Tiled results compared with whole ones, and the memory that tiles take.

use wgdenoise::{
    Denoiser, Element, Gpu, Inputs, Layout, Options, PassDescriptor, PassImage, Precision, Quality,
    Weights, wgpu,
};

use crate::support::{denoiser, denoiser_of, frame, images, run, same_bits, tiny, tiny_kernels};
use wgdenoise_testing::gpu::{gpu, kernel_sets};
use wgdenoise_testing::run_cases;

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let sizes = [(131, 67), (16, 301), (97, 97), (255, 1)];
    for weights in [tiny(), tiny_kernels()] {
        let sets = kernel_sets(Precision::F32).into_iter();
        run_cases(sets.flat_map(|k| sizes.map(|size| (k, size))), |&(kernels, (width, height))| {
            let images = images(width, height);
            let frame = frame(&images, Inputs::ALL);
            let options = Options::default().kernels(kernels);
            let whole = denoiser_of(&weights, &options).denoise(&frame).unwrap();
            let tiled = denoiser_of(&weights, &options.tile(80));
            let tiles = tiled.tile_plan(width, height, Inputs::ALL).unwrap().tiles.len();
            if tiles < 2 {
                return Err(format!("{tiles} tile tests nothing"));
            }
            same_bits(&tiled.denoise(&frame).unwrap(), &whole)
        });
    }
}

#[test]
fn the_built_in_weights_make_the_same_bits_in_tiles() {
    let images = images(600, 310);
    for precision in [Precision::F32, Precision::F16] {
        let weights = Weights::builtin(Quality::Fast).unwrap();
        let run = |tile| {
            let options = Options::default().precision(precision).tile(tile);
            let (device, queue) = (&gpu().device, &gpu().queue);
            let denoiser = Denoiser::new(device, queue, &weights, &options).unwrap();
            let tiles = denoiser.tile_plan(600, 310, Inputs::ALL).unwrap().tiles.len();
            (denoiser.denoise(&frame(&images, Inputs::ALL)).unwrap(), tiles)
        };
        let ((whole, one), (tiled, many)) = (run(None), run(Some(288)));
        assert!(one == 1 && many > 4, "{one} and {many} tiles");
        same_bits(&tiled, &whole).unwrap();
    }
}

#[test]
fn the_memory_budget_does_not_change_the_result() {
    let images = images(200, 150);
    let frame = frame(&images, Inputs::ALL);
    let denoiser = denoiser(&Options::default().memory_bytes(2 << 20));
    let planned = denoiser.memory_bytes(200, 150, Inputs::ALL).unwrap();
    assert!(planned <= 2 << 20, "{planned} bytes");
    assert!(denoiser.tile_plan(200, 150, Inputs::ALL).unwrap().tiles.len() > 1);
    let found = denoiser.denoise(&frame).unwrap();
    same_bits(&found, &run(&Options::default(), &frame)).unwrap();
}

#[test]
fn what_a_pass_allocates_is_what_was_planned() {
    allocates_what_was_planned(4 << 20, false);
}

/// The history of frames takes 48 bytes for each of the 90000 pixels.
#[test]
fn what_a_pass_with_motion_allocates_is_what_was_planned() {
    allocates_what_was_planned(8 << 20, true);
}

/// Uses its own device, so that no other test allocates meanwhile.
fn allocates_what_was_planned(budget: u64, has_motion: bool) {
    let gpu = Gpu::open(None).unwrap();
    let allocated = || {
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        gpu.device.generate_allocator_report().expect("this backend reports").total_allocated_bytes
    };
    let options = Options::default().memory_bytes(budget);
    let denoiser = Denoiser::new(&gpu.device, &gpu.queue, &tiny(), &options).unwrap();
    let [noisy, clean] = [(); 2].map(|()| pass_buffer(&gpu.device));
    let before = allocated();
    let image =
        |buffer| PassImage::Buffer { buffer, element: Element::F32, layout: Layout::packed(300) };
    let motion = has_motion.then_some(image(&noisy));
    let descriptor = PassDescriptor::new(300, 300, image(&noisy), image(&clean)).motion(motion);
    let pass = denoiser.pass(&descriptor).unwrap();
    let used = allocated() - before;
    // The plan omits uniforms, exposure bins and alignment: a few kilobytes.
    assert!(used > budget / 2 && used < budget + (budget >> 4), "{used} of {budget} bytes");
    let frame = || {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        pass.encode(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        allocated() - before
    };
    // The first submission also frees the staging memory for the uniforms.
    let frames = [(); 3].map(|()| frame());
    assert!(frames[0] <= used && frames[1..] == [frames[0]; 2], "{frames:?} after {used}");
}

fn pass_buffer(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 300 * 300 * 12,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}

#[test]
fn a_budget_below_the_history_of_frames_is_refused_with_what_it_needs() {
    let denoiser = denoiser(&Options::default().memory_bytes(4 << 20));
    let buffer = pass_buffer(&gpu().device);
    let layout = Layout::packed(300);
    let image = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    let output = pass_buffer(&gpu().device);
    let output = PassImage::Buffer { buffer: &output, element: Element::F32, layout };
    let descriptor = PassDescriptor::new(300, 300, image, output);
    let error = denoiser.pass(&descriptor.motion(image)).unwrap_err().to_string();
    assert!(error.contains("5 of them for the last frames"), "{error}");
}

#[test]
fn a_budget_below_the_smallest_tile_is_refused_with_what_it_needs() {
    let denoiser = denoiser(&Options::default().memory_bytes(10_000));
    let error = denoiser.tile_plan(500, 500, Inputs::ALL).unwrap_err().to_string();
    assert!(error.contains("memory") && error.contains("MiB"), "{error}");
}
