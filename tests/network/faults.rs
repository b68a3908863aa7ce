//! Lost devices, slow devices and wrong results.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use wgdenoise::{
    Denoiser, Element, Error, Frame, Gpu, Image, Inputs, KernelSet, Layout, Options,
    PassDescriptor, PassImage, Precision, Quality, Result, Weights, wgpu,
};

use crate::support::{denoiser, frame, images, run, same_bits, tiny};
use wgdenoise_testing::gpu::{factors, gpu, has_halves, variants};
use wgdenoise_testing::run_cases;

/// A separate device that the test may lose.
fn device() -> Gpu {
    Gpu::open(None).expect("the tests need an adapter")
}

fn assert_lost<T>(result: Result<T>) {
    match result.map(|_| ()).unwrap_err() {
        Error::DeviceLost { .. } => {}
        other => panic!("{other}"),
    }
}

#[test]
fn every_call_says_that_the_device_is_lost() {
    let Gpu { device, queue, .. } = device();
    let options = Options::default();
    let denoiser = Denoiser::new(&device, &queue, &tiny(), &options).unwrap();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 40 * 30 * 12,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    device.destroy();
    let images = images(40, 30);
    let frame = frame(&images, Inputs::ALL);
    assert_lost(denoiser.denoise(&frame));
    assert_lost(denoiser.profile(&frame, 1));
    assert_lost(Denoiser::new(&device, &queue, &tiny(), &options));
    let layout = Layout::packed(40);
    let image = PassImage::Buffer { buffer: &buffer, element: Element::F32, layout };
    assert_lost(denoiser.pass(&PassDescriptor::new(40, 30, image, image)));
}

#[test]
fn a_device_that_is_lost_between_two_tiles_ends_the_work() {
    let Gpu { device, queue, .. } = device();
    let options = Options::default().tile(80);
    let denoiser = Denoiser::new(&device, &queue, &tiny(), &options).unwrap();
    let images = images(200, 150);
    let tiles = denoiser.tile_plan(200, 150, Inputs::ALL).unwrap().tiles.len();
    assert!(tiles > 3, "{tiles} tiles");
    let mut finished = 0;
    assert_lost(denoiser.denoise_with_progress(&frame(&images, Inputs::ALL), &mut |done, of| {
        finished = done;
        if done == of / tiles * 2 {
            device.destroy();
        }
        assert!(done <= of / tiles * 2, "{done} of {of} calls");
    }));
    assert!(finished > 0);
}

#[test]
fn work_that_is_too_long_is_an_error_and_the_device_can_be_used_on() {
    let Gpu { device, queue, info, .. } = device();
    let images = images(600, 400);
    let frame = frame(&images, Inputs::ALL);
    let options = Options::default().timeout(Duration::from_micros(1));
    // A second of work on a fast adapter, so it cannot finish before the wait begins.
    let large = Weights::builtin(Quality::High).unwrap();
    let hasty = Denoiser::new(&device, &queue, &large, &options).unwrap();
    let error = hasty.denoise(&frame).map(drop).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::Timeout { .. }), "{text}");
    assert!(text.contains(&info.name) && text.contains("within 1µs"), "{text}");
    drop(hasty);
    let patient = Denoiser::new(&device, &queue, &tiny(), &Options::default()).unwrap();
    let found = patient.denoise(&frame).unwrap();
    same_bits(&found, &run(&Options::default(), &frame)).unwrap();
}

#[test]
fn results_of_every_variant_are_verified() {
    let images = images(70, 50);
    let frame = frame(&images, Inputs::ALL);
    run_cases(variants(), |&(kernels, precision)| {
        let denoiser = denoiser(&Options::default().kernels(kernels).precision(precision));
        let result = denoiser.denoise(&frame).map_err(|e| e.to_string())?;
        let verified = denoiser.verify(&frame, &result).map_err(|e| e.to_string())?;
        let verified = verified.ok_or("there is noise")?;
        // Far below the error that is rejected.
        let is_exact = precision == Precision::F32 && factors(kernels, &[0.1]) == [0.1];
        let most = if is_exact { 1e-5 } else { 8e-4 };
        (verified.rms < most).then_some(()).ok_or_else(|| verified.to_string())
    });
}

const TILED_F32: (KernelSet, Precision) = (KernelSet::Tiled, Precision::F32);
const TILED_F16: (KernelSet, Precision) = (KernelSet::Tiled, Precision::F16);

/// An image, its denoised result, and the denoiser.
struct Case {
    denoiser: Denoiser,
    images: [Image; 3],
    result: Image,
}

impl Case {
    fn new(weights: &Weights, (kernels, precision): (KernelSet, Precision)) -> Self {
        let options = Options::default().precision(precision).kernels(kernels);
        let denoiser = Denoiser::new(&gpu().device, &gpu().queue, weights, &options).unwrap();
        let images = images(70, 50);
        let result = denoiser.denoise(&frame(&images, Inputs::ALL)).unwrap();
        Self { denoiser, images, result }
    }

    fn frame(&self) -> Frame<'_> {
        frame(&self.images, Inputs::ALL)
    }

    /// Verifies the result with some pixels changed.
    fn changed(&self, change: impl Fn([u32; 2], [f32; 3]) -> [f32; 3]) -> Result<()> {
        let width = self.result.width();
        let mut result = self.result.clone();
        for (i, pixel) in (0..).zip(result.pixels_mut()) {
            *pixel = change([i % width, i / width], *pixel);
        }
        self.denoiser.verify(&self.frame(), &result).map(|_| ())
    }
}

fn assert_refused(what: &str, result: Result<()>) {
    match result {
        Err(Error::WrongResult(text)) if text.contains("wrong results") => {}
        other => panic!("{what}: {other:?}"),
    }
}

#[test]
fn wrong_results_are_refused() {
    let half = has_halves().then_some((KernelSet::Half, Precision::F16));
    for variant in [TILED_F32, TILED_F16].into_iter().chain(half) {
        let case = Case::new(&tiny(), variant);
        case.changed(|_, pixel| pixel).expect("nothing is changed");
        let verified = case.denoiser.verify(&case.frame(), &case.result).unwrap().expect("noise");
        let block = |at: [u32; 2]| {
            let rect = verified.rect;
            (0..2).all(|axis| (rect.begin[axis]..rect.end[axis]).contains(&at[axis]))
        };
        let corner = |at: [u32; 2]| at == verified.rect.begin;
        let refused = |what, change: &dyn Fn([u32; 2], [f32; 3]) -> [f32; 3]| {
            assert_refused(&format!("{what}, {variant:?}"), case.changed(change));
        };
        refused("5 % too bright", &|_, p| p.map(|v| v * 1.05));
        refused("5 % too dark", &|_, p| p.map(|v| v * 0.95));
        refused("red and blue exchanged", &|_, [r, g, b]| [b, g, r]);
        refused("a black channel", &|_, [r, _, b]| [r, 0.0, b]);
        refused("a black block", &|at, p| if block(at) { [0.0; 3] } else { p });
        refused("a pixel", &|at, [r, g, b]| if corner(at) { [r * 1.3, g, b] } else { [r, g, b] });
        refused("NaN", &|at, p| if corner(at) { [f32::NAN; 3] } else { p });
        refused("infinity", &|at, p| if corner(at) { [f32::INFINITY; 3] } else { p });
        refused("the input", &|[x, y], _| case.images[0].row(y)[x as usize]);
    }
}

/// The tiny weights with the first value of a tensor shifted.
fn spoiled(tensor: &str) -> Weights {
    let mut bytes = include_bytes!("../fixtures/unet_tiny.safetensors").to_vec();
    let header = 8 + u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[8..header]).unwrap();
    let at = header + json[tensor]["data_offsets"][0].as_u64().expect(tensor) as usize;
    let number: &mut [u8; 4] = (&mut bytes[at..at + 4]).try_into().unwrap();
    *number = (f32::from_le_bytes(*number) + 0.5).to_le_bytes();
    Weights::from_bytes(&bytes).unwrap()
}

#[test]
fn one_wrong_weight_is_found() {
    let right = Case::new(&tiny(), TILED_F16);
    for tensor in ["enc_conv0a.weight", "mid_conva.weight", "dec_conv0b.weight", "out_conv.bias"] {
        let wrong = Case::new(&spoiled(tensor), TILED_F16);
        let found = right.denoiser.verify(&right.frame(), &wrong.result);
        assert_refused(tensor, found.map(|_| ()));
    }
}

/// Imitates a pixel filter with negative lobes, or a partly broken render.
#[test]
fn a_picture_with_bad_values_in_every_block_is_verified() {
    let [noise, ..] = images(70, 50);
    let denoiser = denoiser(&Options::default());
    for bad in [-0.1, f32::NAN, f32::INFINITY] {
        let mut color = noise.clone();
        color.pixels_mut().iter_mut().step_by(5).for_each(|pixel| pixel[1] = bad);
        let frame = Frame::new(&color);
        let mut result = denoiser.denoise(&frame).unwrap();
        let verified = denoiser.verify(&frame, &result).unwrap();
        assert!(verified.is_some(), "noise beside {bad} is not seen");
        result.pixels_mut().iter_mut().for_each(|pixel| pixel[0] *= 1.1);
        assert_refused(
            &format!("too red beside {bad}"),
            denoiser.verify(&frame, &result).map(|_| ()),
        );
    }
}

#[test]
fn a_block_without_bad_values_is_verified_if_there_is_one() {
    let [mut color, ..] = images(70, 50);
    for (i, pixel) in (0..).zip(color.pixels_mut()) {
        let (x, y) = (i % 70, i / 70);
        let is_sound = (32..48).contains(&x) && (16..32).contains(&y);
        // The other blocks are noisier.
        *pixel = if is_sound { pixel.map(|v| 4.0 + 0.1 * v) } else { *pixel };
        pixel[2] = if !is_sound && x % 5 == 0 { -0.1 } else { pixel[2] };
    }
    let frame = Frame::new(&color);
    let denoiser = denoiser(&Options::default());
    let result = denoiser.denoise(&frame).unwrap();
    let verified = denoiser.verify(&frame, &result).unwrap().expect("noise");
    assert_eq!(verified.rect.begin, [32, 16]);
}

#[test]
fn a_picture_without_noise_has_nothing_to_verify() {
    let color = Image::filled(40, 30, [0.5, 0.4, 0.3]).unwrap();
    let frame = Frame::new(&color);
    let denoiser = denoiser(&Options::default());
    let result = denoiser.denoise(&frame).unwrap();
    assert_eq!(denoiser.verify(&frame, &result).unwrap(), None);
    let error = denoiser.verify(&frame, &images(40, 31)[0]).unwrap_err().to_string();
    assert!(error.contains("40×31"), "{error}");
}

#[test]
fn a_hosts_handlers_stay_and_hear_nothing_of_what_is_told_as_an_error() {
    let Gpu { device, queue, .. } = device();
    let [errors, losses] = [(); 2].map(|()| Arc::new(AtomicUsize::new(0)));
    let (error, loss) = (errors.clone(), losses.clone());
    device.on_uncaptured_error(Arc::new(move |_| _ = error.fetch_add(1, Relaxed)));
    device.set_device_lost_callback(move |_, _| _ = loss.fetch_add(1, Relaxed));
    let counts = || (errors.load(Relaxed), losses.load(Relaxed));

    let denoiser = Denoiser::new(&device, &queue, &tiny(), &Options::default()).unwrap();
    let images = images(40, 30);
    let frame = frame(&images, Inputs::ALL);
    denoiser.denoise(&frame).unwrap();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 40, height: 30, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    });
    texture.destroy();
    let image = PassImage::Texture(&texture);
    denoiser.pass(&PassDescriptor::new(40, 30, image, image)).unwrap_err();
    assert_eq!(counts(), (0, 0));

    let nothing = wgpu::BufferUsages::empty();
    let label = None;
    let refused =
        wgpu::BufferDescriptor { label, size: 4, usage: nothing, mapped_at_creation: false };
    let _ = device.create_buffer(&refused);
    assert_eq!(counts(), (1, 0));
    device.destroy();
    assert_lost(denoiser.denoise(&frame));
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(counts(), (1, 1));
}

/// All sources in a folder of `src`, recursively, by path.
fn sources(folder: &str) -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(folder);
    let of_entry = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.unwrap().path();
        let name = format!("{folder}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            return sources(&format!("{name}/"));
        }
        vec![(name, std::fs::read_to_string(path).unwrap())]
    };
    let mut sources: Vec<_> = path.read_dir().unwrap().flat_map(of_entry).collect();
    sources.sort();
    sources
}

#[test]
fn errors_of_the_hosts_work_in_the_callback_stay_the_hosts() {
    let Gpu { device, queue, .. } = device();
    let denoiser = Denoiser::new(&device, &queue, &tiny(), &Options::default()).unwrap();
    let reported = Arc::new(AtomicUsize::new(0));
    let counter = reported.clone();
    device.on_uncaptured_error(Arc::new(move |_| {
        counter.fetch_add(1, Relaxed);
    }));
    let (images, mut callbacks) = (images(64, 48), 0);
    let refused = wgpu::BufferDescriptor {
        label: None,
        size: 4,
        usage: wgpu::BufferUsages::empty(),
        mapped_at_creation: false,
    };
    let denoised = denoiser.denoise_with_progress(&frame(&images, Inputs::ALL), &mut |_, _| {
        let _ = device.create_buffer(&refused);
        callbacks += 1;
    });
    denoised.unwrap();
    assert!(callbacks > 0);
    assert_eq!(reported.load(Relaxed), callbacks);
}

#[test]
fn the_engine_sets_no_handler_of_the_hosts_process() {
    let users = |words: &[&str]| -> Vec<String> {
        let uses = |(name, text): (String, String)| {
            words.iter().any(|word| text.contains(word)).then_some(name)
        };
        sources("").into_iter().filter_map(uses).collect()
    };
    let handlers = ["on_uncaptured_error", "device_lost_callback", "sigaction", "signal_hook"];
    assert_eq!(users(&handlers), [""; 0]);
    assert_eq!(users(&["set_hook"]), ["panics.rs"]);
    // Programs may call it; the engine itself never does.
    assert_eq!(users(&["silence_caught"]), ["panics.rs"]);
}
