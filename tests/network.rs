//! The whole network on the adapter: against the reference, tiled against whole, with fewer
//! inputs against zeros, in a caller's encoder against the blocking call.

mod common;

use common::gpu::{VARIANTS, buffer, context, gpu, read_back};
use common::{Random, Tolerance, compare, image_tensor, run_cases};
use wgdenoise::model::{INPUT, Inputs};
use wgdenoise::reference::{self, Tensor};
use wgdenoise::wgpu;
use wgdenoise::{
    Denoiser, Frame, Image, KernelSet, Layout, Options, PassDescriptor, PassImage, Precision,
    Weights,
};

/// Three widths (two poolings, alignment 4), nine inputs, batch norm stored raw.
fn tiny() -> Weights {
    let bytes = include_bytes!("fixtures/unet_tiny.safetensors");
    Weights::from_bytes(bytes).expect("the fixture follows the format")
}

fn denoiser(options: &Options) -> Denoiser {
    Denoiser::new(&gpu().device, &gpu().queue, &tiny(), options).expect("the device works")
}

fn images(width: u32, height: u32) -> [Image; 3] {
    let mut random = Random::new(u64::from(width * 7 + height));
    let mut image = |value: fn(f32) -> f32| {
        let pixels = (0..width * height).map(|_| [0; 3].map(|_| value(random.value())));
        Image::new(width, height, pixels.collect()).expect("the count is right")
    };
    [image(|v| (v * 6.0).exp2()), image(f32::abs), image(|v| v)]
}

fn frame(images: &[Image; 3], inputs: Inputs) -> Frame<'_> {
    Frame {
        color: &images[0],
        albedo: inputs.albedo.then_some(&images[1]),
        normal: inputs.normal.then_some(&images[2]),
        input_scale: None,
    }
}

fn run(options: &Options, frame: &Frame<'_>) -> Image {
    denoiser(options).denoise(frame, &mut |_, _| {}).expect("the frame is fine")
}

/// What the naive functions make of a frame, from its pixels to the result's.
fn expected(weights: &Weights, frame: &Frame<'_>) -> Image {
    let scale = frame.input_scale.unwrap_or_else(|| reference::autoexposure(frame.color));
    let weights = weights.for_inputs(frame.inputs()).expect("the inputs are known");
    let alignment = weights.network.alignment();
    let input = reference::input_process(frame.color, frame.albedo, frame.normal, scale, alignment);
    let output = reference::run(&weights.network, |layer| weights.params(layer), &input);
    let (width, height) = frame.color.size();
    reference::output_process(&output, scale, width, height)
}

/// In the transfer domain, where the network works: twelve layers of f32 sums come to 1e-6,
/// and the exposure's 5e-5 moves the logarithmic curve by 3e-6.
const F32: Tolerance = Tolerance { absolute: 1e-5, relative: 0.0 };
/// Twelve stores that round by 2⁻¹¹ add up to 6e-3 at worst, before weights shrink or grow it.
const F16: Tolerance = Tolerance { absolute: 6e-3, relative: 0.0 };

/// An image in the transfer domain.
fn encoded(image: &Image, scale: f32) -> Tensor {
    let mut tensor = image_tensor(image);
    let encode = |v: f32| reference::pu(f64::from(v) * f64::from(scale)) as f32;
    tensor.data.iter_mut().for_each(|v| *v = encode(*v));
    tensor
}

const SETS: [Inputs; 4] = [
    Inputs { albedo: false, normal: false },
    Inputs { albedo: true, normal: false },
    Inputs { albedo: false, normal: true },
    Inputs::ALL,
];

#[test]
fn every_variant_equals_the_reference_for_every_input_set() {
    let images = images(37, 22);
    let cases = SETS.iter().flat_map(|&inputs| VARIANTS.map(|variant| (inputs, variant)));
    run_cases(cases, |&(inputs, (kernels, precision))| {
        let frame = frame(&images, inputs);
        let found = run(&Options { kernels, precision, ..Options::default() }, &frame);
        let tolerance = if precision == Precision::F32 { F32 } else { F16 };
        let expected = expected(&tiny(), &frame);
        let scale = reference::autoexposure(frame.color);
        compare(&encoded(&found, scale), &encoded(&expected, scale), tolerance)
    });
}

#[test]
fn tiles_make_the_same_bits_as_the_whole_image() {
    let kernels = [KernelSet::Plain, KernelSet::Tiled, KernelSet::Simd];
    let sizes = [(131, 67), (16, 301), (97, 97), (255, 1)];
    let cases = kernels.iter().flat_map(|&k| sizes.map(|size| (k, size)));
    run_cases(cases, |&(kernels, (width, height))| {
        let images = images(width, height);
        let frame = frame(&images, Inputs::ALL);
        let whole = run(&Options { kernels, ..Options::default() }, &frame);
        let options = Options { kernels, tile: Some(60), ..Options::default() };
        let tiles = denoiser(&options).tile_plan(width, height, Inputs::ALL).unwrap().tiles.len();
        if tiles < 2 {
            return Err(format!("{tiles} tile tests nothing"));
        }
        same_bits(&run(&options, &frame), &whole)
    });
}

#[test]
fn the_memory_budget_is_kept_and_does_not_change_the_result() {
    let images = images(200, 150);
    let frame = frame(&images, Inputs::ALL);
    let options = Options { memory_bytes: 1 << 20, ..Options::default() };
    let denoiser = denoiser(&options);
    let used = denoiser.memory_bytes(200, 150, Inputs::ALL).unwrap();
    assert!(used <= 1 << 20, "{used} bytes");
    assert!(denoiser.tile_plan(200, 150, Inputs::ALL).unwrap().tiles.len() > 1);
    let found = denoiser.denoise(&frame, &mut |_, _| {}).unwrap();
    same_bits(&found, &run(&Options::default(), &frame)).unwrap();
}

#[test]
fn a_budget_below_the_smallest_tile_is_refused_with_what_it_needs() {
    let denoiser = denoiser(&Options { memory_bytes: 10_000, ..Options::default() });
    let error = denoiser.tile_plan(500, 500, Inputs::ALL).unwrap_err().to_string();
    assert!(error.contains("memory") && error.contains("MiB"), "{error}");
}

#[test]
fn absent_inputs_make_the_same_bits_as_zeros() {
    run_cases(SETS, |&inputs| {
        let (all, sliced) = (tiny(), tiny().for_inputs(inputs).expect("a subset"));
        let mut random = Random::new(4);
        let cut = random.tensor(inputs.channels(), 24, 40);
        let kept = inputs.channels_of(Inputs::ALL);
        let zeros = Tensor::from_fn(9, 24, 40, |c, y, x| {
            kept.iter().position(|&k| k == c).map_or(0.0, |i| cut.at(i, y, x))
        });
        for kernels in [KernelSet::Plain, KernelSet::Tiled, KernelSet::Simd] {
            let few = first_layer(&sliced, kernels, &cut);
            let many = first_layer(&all, kernels, &zeros);
            let differ =
                few.data.iter().zip(&many.data).filter(|(a, b)| a.to_bits() != b.to_bits());
            if differ.count() > 0 {
                return Err(format!("{kernels:?}: the first layer differs"));
            }
        }
        Ok(())
    });
}

/// The only layer that reads the network's input.
fn first_layer(weights: &Weights, kernels: KernelSet, input: &Tensor) -> Tensor {
    use wgdenoise::ops::{conv3x3::conv3x3, input_process::channel_map};
    let readers = weights.network.layers.iter().filter(|l| l.inputs.contains(&INPUT));
    assert_eq!(readers.map(|l| l.name.as_str()).collect::<Vec<_>>(), ["enc_conv0a"]);
    let params = weights.params("enc_conv0a");
    let (context, map) = (context(Precision::F32), channel_map(input.channels));
    let operator = conv3x3(context, kernels, &params, &map, true);
    let shape = [params.bias.len(), input.height, input.width];
    common::gpu::run(context, &operator, input, &map, shape)
}

#[test]
fn the_same_input_makes_the_same_bits_every_time() {
    let images = images(50, 41);
    let frame = frame(&images, Inputs::ALL);
    let first = run(&Options::default(), &frame);
    for _ in 0..3 {
        same_bits(&run(&Options::default(), &frame), &first).unwrap();
    }
}

#[test]
fn a_pass_in_the_callers_encoder_makes_the_same_bits_as_the_blocking_call() {
    let images = images(90, 70);
    let expected = run(&Options::default(), &frame(&images, Inputs::ALL));
    for tile in [None, Some(60)] {
        let denoiser = denoiser(&Options { tile, ..Options::default() });
        let context = context(Precision::F32);
        let buffers = images.each_ref().map(|i| buffer(context, bytemuck::cast_slice(i.pixels())));
        let output = buffer(context, &vec![0; 90 * 70 * 12]);
        let layout = Layout::packed(90);
        let image = |buffer| PassImage::Buffer { buffer, layout };
        let pass = denoiser
            .pass(&PassDescriptor {
                width: 90,
                height: 70,
                color: image(&buffers[0]),
                albedo: Some(image(&buffers[1])),
                normal: Some(image(&buffers[2])),
                output: image(&output),
                input_scale: None,
            })
            .unwrap();
        let bytes = read_back(context, output.size(), |encoder, target| {
            pass.encode(encoder);
            encoder.copy_buffer_to_buffer(&output, 0, target, 0, output.size());
        });
        let found = Image::new(90, 70, bytemuck::pod_collect_to_vec(&bytes)).unwrap();
        same_bits(&found, &expected).unwrap();
    }
}

#[test]
fn a_pass_refuses_images_that_do_not_fit() {
    let (context, denoiser) = (context(Precision::F32), denoiser(&Options::default()));
    let (enough, short) = (buffer(context, &[0; 192]), buffer(context, &[0; 188]));
    let other = buffer(context, &[0; 192]);
    let unusable = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 192,
        usage: wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let refuse = |color, output, width, expected: &str| {
        let image = |buffer| PassImage::Buffer { buffer, layout: Layout::packed(4) };
        let error = denoiser.pass(&PassDescriptor {
            width,
            height: 4,
            color: image(color),
            albedo: None,
            normal: None,
            output: image(output),
            input_scale: None,
        });
        let message = error.expect_err("it should be refused").to_string();
        assert!(message.contains(expected), "{message}");
    };
    refuse(&short, &enough, 4, "color of 4×4 pixels needs a buffer of 192 bytes, found 188");
    refuse(&enough, &short, 4, "output of 4×4 pixels");
    refuse(&unusable, &enough, 4, "STORAGE");
    refuse(&other, &other, 4, "same buffer");
    refuse(&other, &enough, 0, "at least 1");
}

#[test]
fn frames_that_do_not_fit_together_are_refused() {
    let denoiser = denoiser(&Options::default());
    let (color, small) = (images(8, 8), images(8, 7));
    let frame = Frame { albedo: Some(&small[1]), ..frame(&color, Inputs::default()) };
    let error = denoiser.denoise(&frame, &mut |_, _| {}).unwrap_err().to_string();
    assert!(error.contains("albedo is 8×7, but the colour is 8×8"), "{error}");
    let frame = Frame { albedo: None, input_scale: Some(f32::NAN), ..frame };
    let error = denoiser.denoise(&frame, &mut |_, _| {}).unwrap_err().to_string();
    assert!(error.contains("input scale is NaN"), "{error}");
}

#[test]
fn an_unknown_adapter_is_an_error_that_says_what_there_is() {
    let error = wgdenoise::Gpu::open(Some("no such adapter")).unwrap_err().to_string();
    assert!(error.contains(&gpu().info.name) && error.contains("mesa-vulkan-drivers"), "{error}");
}

/// The same test binary again, where the Vulkan loader finds no driver.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_the_tests_fail_instead_of_being_skipped() {
    let binary = std::env::current_exe().expect("the binary that runs");
    let output = std::process::Command::new(binary)
        .args(["the_same_input_makes_the_same_bits_every_time", "--exact"])
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|key| (key, "/nonexistent")))
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("the tests need an adapter"), "{text}");
}

fn same_bits(found: &Image, expected: &Image) -> Result<(), String> {
    if found.size() != expected.size() {
        return Err(format!("size {:?}, expected {:?}", found.size(), expected.size()));
    }
    let bits = |image: &Image| -> Vec<[u32; 3]> {
        image.pixels().iter().map(|p| p.map(f32::to_bits)).collect()
    };
    match bits(found).iter().zip(&bits(expected)).position(|(a, b)| a != b) {
        None => Ok(()),
        Some(i) => Err(format!("pixel {i} of {:?} differs", found.size())),
    }
}
