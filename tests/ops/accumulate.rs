//! The operator, compared with its reference.

use wgdenoise::internals::ops::image::ImageFormat;
use wgdenoise::internals::ops::tile::Layout;
use wgdenoise::internals::reference;
use wgdenoise::wgpu::TextureFormat as Texture;

use crate::film::{F16, F32, Formats, Frame, Sequence, sizes_and_features, texture};
use wgdenoise_testing::image::{Pixel, cpu_image};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// Light is in [0, 2]. Sums of 16 to 27 terms round the differences that determine agreement by up
/// to 2⁻²¹; divided by the smallest scale, 0.1, and times the steepest slope of exp(−x²), 0.86,
/// that is 4e-6, or 3e-5 over the history's eight frames. WGSL allows exp an error of 3 + 2 |x|
/// units in the last place, which is less.
const TOLERANCE: Tolerance = Tolerance { absolute: 6e-5, relative: 0.0 };

/// The reference's results for all frames: the color and then each layer.
fn expected(
    frames: &[Frame],
    size: [u32; 2],
    formats: &Formats,
    input_scale: f32,
) -> Vec<Vec<Vec<[f64; 3]>>> {
    let mut history: Option<reference::History> = None;
    let mut results = Vec::new();
    for frame in frames {
        let frame = frame.stored(formats);
        let image = |pixels: &[Pixel]| (!pixels.is_empty()).then(|| cpu_image(pixels, size));
        let (albedo, normal) = (image(&frame.albedo), image(&frame.normal));
        let depth: Vec<_> = frame.depth.iter().map(|pixel| pixel[0]).collect();
        let motion: Vec<_> = frame.motion.iter().map(|&[x, y, ..]| [x, y]).collect();
        let layers: Vec<_> = frame.layers.iter().map(|layer| cpu_image(layer, size)).collect();
        let frame = reference::Frame {
            denoised: &cpu_image(&frame.denoised, size),
            layers: &layers.iter().collect::<Vec<_>>(),
            motion: &motion,
            albedo: albedo.as_ref(),
            normal: normal.as_ref(),
            depth: formats.depth.map(|_| depth.as_slice()),
            input_scale,
        };
        let next = reference::accumulate(&frame, history.as_ref(), 8.0);
        let color = next.0.iter().map(|past| past.color).collect();
        let layer = |l: usize| next.0.iter().map(|past| past.layers[l]).collect();
        results.push([color].into_iter().chain((0..layers.len()).map(layer)).collect());
        history = Some(next);
    }
    results
}

/// Compares every frame, including its layers.
pub(crate) fn check(
    frames: &[Frame],
    size: [u32; 2],
    formats: Formats,
    input_scale: f32,
) -> Result<(), String> {
    let mut sequence = Sequence::new(size, formats, input_scale);
    let expected = expected(frames, size, &formats, input_scale);
    for (i, (frame, expected)) in frames.iter().zip(expected).enumerate() {
        let found = sequence.next_with_layers(frame);
        let own = [&frame.denoised].into_iter().chain(&frame.layers);
        for (l, ((found, expected), own)) in found.iter().zip(&expected).zip(own).enumerate() {
            let format = if l == 0 { formats.output.0 } else { formats.layer.0 };
            check_image(found, expected, own, size, tolerance(format))
                .map_err(|e| format!("frame {i}, image {l}: {e}"))?;
        }
    }
    Ok(())
}

fn check_image(
    found: &[Pixel],
    expected: &[[f64; 3]],
    own: &[Pixel],
    size: [u32; 2],
    tolerance: Tolerance,
) -> Result<(), String> {
    let pixels: Vec<Pixel> =
        expected.iter().map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0]).collect();
    let [a, b] = [found, &pixels].map(|pixels: &[Pixel]| image_tensor(&cpu_image(pixels, size)));
    compare(&a, &b, tolerance)?;
    let alpha = found.iter().zip(own).map(|(a, b)| (a[3] - b[3]).abs());
    let alpha = alpha.fold(0.0, f32::max);
    if alpha > tolerance.relative * 2.0 { Err(format!("alpha is off by {alpha}")) } else { Ok(()) }
}

/// 16-bit formats round by 2⁻¹¹, and drivers may truncate.
fn tolerance(output: ImageFormat) -> Tolerance {
    match output {
        F16 | ImageFormat::Texture(Texture::Rgba16Float) => {
            Tolerance { relative: 1.0 / 1024.0, ..TOLERANCE }
        }
        _ => TOLERANCE,
    }
}

pub(crate) fn frames(seed: u64, size: [u32; 2], count: usize) -> Vec<Frame> {
    let mut random = Random::new(seed);
    (0..count).map(|_| Frame::random(&mut random, size)).collect()
}

#[test]
fn accumulate_equals_the_reference_in_every_format() {
    let size = [13, 7];
    let all = Formats::all(13);
    let gaps = |format, channels| (format, Layout::new(5, 71, 5).with_channels(channels));
    let motion = [
        gaps(F32, 2),
        gaps(F16, 3),
        texture(Texture::Rg16Float),
        texture(Texture::Rg32Float),
        texture(Texture::Rgba16Float),
        texture(Texture::Rgba32Float),
    ];
    let feature = [gaps(F32, 3), gaps(F16, 3), texture(Texture::Rgba32Float)];
    let depth =
        [gaps(F32, 1), gaps(F16, 2), texture(Texture::R16Float), texture(Texture::R32Float)];
    let outputs =
        [gaps(F32, 4), gaps(F16, 4), texture(Texture::Rgba16Float), texture(Texture::Rgba32Float)];
    let mut cases: Vec<_> = motion.map(|motion| Formats { motion, ..all }).into();
    cases.extend(feature.map(|of| Formats { albedo: Some(of), ..all }));
    cases.extend(feature.map(|of| Formats { normal: Some(of), ..all }));
    cases.extend(depth.map(|of| Formats { depth: Some(of), ..all }));
    cases.extend(outputs.map(|output| Formats { output, ..all }));
    let bytes = Some(texture(Texture::Rgba8Unorm));
    cases.push(Formats { albedo: bytes, ..all });
    cases.push(Formats { normal: Some(texture(Texture::Rgba8Snorm)), ..all });
    cases.push(Formats { normal: Some(texture(Texture::Rgb10a2Unorm)), unorm: true, ..all });
    run_cases(cases, |&formats| check(&frames(3, size, 3), size, formats, 0.5));
}

#[test]
fn accumulate_equals_the_reference_at_any_size_and_without_any_feature() {
    run_cases(sizes_and_features(), |&(size, set)| {
        let formats = Formats::with_features(size[0], set);
        check(&frames(u64::from(set), size, 4), size, formats, 1.0)
    });
}

#[test]
fn what_is_no_number_has_no_history() {
    let size = [13, 7];
    let frames: Vec<_> = frames(9, size, 3).into_iter().map(Frame::with_broken_pixels).collect();
    check(&frames, size, Formats::all(13), 1.0).unwrap();
}
