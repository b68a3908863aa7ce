//! The time of each kernel call.

use wgdenoise::{CallProfile, Inputs, KernelSet, Options, Precision, Quality, Weights};

use crate::support::{denoiser, frame, images};
use wgdenoise_testing::gpu::{fused_sets, gpu};

#[test]
fn a_profile_has_every_call_in_order_and_the_work_of_the_fused_network() {
    let weights = Weights::builtin(Quality::Balanced).unwrap();
    for kernels in fused_sets(Precision::F16) {
        let options = Options::default().kernels(kernels).precision(Precision::F16);
        let denoiser =
            wgdenoise::Denoiser::new(&gpu().device, &gpu().queue, &weights, &options).unwrap();
        let images = images(64, 48);
        check(kernels, &denoiser.profile(&frame(&images, Inputs::ALL), 3).unwrap());
    }
}

fn check(kernels: KernelSet, profile: &[CallProfile]) {
    let names: Vec<_> = profile.iter().map(|row| row.name.as_str()).collect();
    let convs = names.iter().filter(|name| name.contains("conv") && !name.starts_with("kernel"));
    assert_eq!(convs.count(), 18, "{names:?}");
    let (first, last) = match kernels {
        set if set.is_for_gpus() => ("input+enc_conv0a", "dec_conv0b+kernel_conv0"),
        _ => ("input_process", "dec_conv0b+kernel_conv0"),
    };
    let logits = names.iter().rposition(|name| name.contains("conv")).expect("there are some");
    assert_eq!((names[3], names[logits]), (first, last), "{kernels}: {names:?}");
    let levels = ["pyramid0", "pyramid1", "pyramid2", "pyramid3", "pyramid4"];
    let results = ["gather4", "gather3", "gather2", "gather1", "gather0"];
    let stored = levels.into_iter().skip(usize::from(kernels != KernelSet::Simd));
    assert_eq!(names[logits + 1..], stored.chain(results).collect::<Vec<_>>(), "{kernels}");
    for row in profile {
        assert!(row.seconds.len() == 3 && row.seconds.is_sorted(), "{row:?}");
        assert!(row.seconds[0] > 0.0 && row.median() == row.seconds[1], "{row:?}");
    }
    // As trained, minus what folding the transposed convolutions saves: with c channels at a level
    // and C below it, c C + 9 c² products per pixel become 4 c C.
    let macs: f64 = profile.iter().map(|row| row.macs).sum();
    let weights = Weights::builtin(Quality::Balanced).unwrap();
    let widths: Vec<_> = weights.metadata().widths.iter().map(|&width| width as f64).collect();
    let saved = |(l, pair): (usize, &[f64])| {
        (9.0 * pair[0] - 3.0 * pair[1]) * pair[0] / 4_f64.powi(l as i32)
    };
    let expected = weights.macs_per_pixel() - widths.windows(2).enumerate().map(saved).sum::<f64>();
    assert!((macs / (64.0 * 48.0) / expected - 1.0).abs() < 1e-3, "{macs}");
}

#[test]
fn a_convolution_too_wide_for_the_logits_stays_a_call_of_its_own() {
    let weights = Weights::builtin(Quality::High).unwrap();
    let (device, queue) = (&gpu().device, &gpu().queue);
    let denoiser = wgdenoise::Denoiser::new(device, queue, &weights, &Options::default()).unwrap();
    let images = images(32, 16);
    let profile = denoiser.profile(&frame(&images, Inputs::ALL), 1).unwrap();
    let convs: Vec<_> = profile.iter().filter(|row| row.name.contains("conv")).collect();
    let ends: Vec<_> = convs.iter().rev().map(|row| row.name.as_str()).take(2).collect();
    assert_eq!(ends, ["kernel_conv0", "dec_conv0b"]);
    // The 1×1 convolution from 24 channels to 12 logits, read and stored in 16 bits.
    let logits = convs.last().expect("there are calls");
    let pixels = 32.0 * 16.0;
    assert_eq!((logits.macs, logits.bytes), (12.0 * 24.0 * pixels, (48.0 + 24.0) * pixels));
}

#[test]
fn tiles_add_up() {
    let images = images(150, 90);
    let frame = frame(&images, Inputs::ALL);
    let whole = denoiser(&Options::default()).profile(&frame, 1).unwrap();
    let options = Options::default().tile(96);
    let tiled = denoiser(&options).profile(&frame, 1).unwrap();
    assert_eq!(whole.len(), tiled.len());
    let sum = |rows: &[CallProfile]| rows.iter().map(|row| row.macs).sum::<f64>();
    assert!(sum(&tiled) > 1.2 * sum(&whole), "{} and {}", sum(&tiled), sum(&whole));
}
