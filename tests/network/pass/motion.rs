//! Frames averaged along their motion.

use wgdenoise::internals::reference;
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{
    Denoiser, Element, Image, ImageFormat, InputScale, Inputs, Layout, Options, Pass,
    PassDescriptor,
};

use super::{F32, Scene, opaque};
use crate::support::{denoiser, denoiser_of, frame, images, tiny_kernels};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

pub(super) const SIZE: [u32; 2] = [90, 70];
const SCALE: f32 = 0.7;

/// A frame's images: color, albedo, normal, motion and depth.
pub(super) type Contents = [Vec<Pixel>; 5];

/// Frames of a scene with fixed albedo and normals, and new noise in each.
pub(super) fn sequence(count: usize) -> Vec<Contents> {
    let [color, albedo, normal] = images(SIZE[0], SIZE[1]);
    let mut random = Random::new(21);
    let mut pixels = |value: &mut dyn FnMut(&mut Random) -> Pixel| -> Vec<Pixel> {
        (0..SIZE[0] * SIZE[1]).map(|_| value(&mut random)).collect()
    };
    let mut frame = || {
        let noise = pixels(&mut |r| [1.0 + 0.3 * r.value(); 4]);
        let noisy = opaque(&color).into_iter().zip(noise);
        [
            noisy.map(|(color, noise)| [0, 1, 2, 3].map(|c| color[c] * noise[c])).collect(),
            opaque(&albedo),
            opaque(&normal),
            pixels(&mut |r| [0.1 * r.value(), 0.1 * r.value(), 0.0, 0.0]),
            pixels(&mut |r| [5.0 + 0.1 * r.value(); 4]),
        ]
    };
    (0..count).map(|_| frame()).collect()
}

/// The images of a pass with motion, filled frame by frame.
pub(super) struct Film {
    pub(super) scene: Scene,
    pub(super) motion: GpuImage,
    depth: GpuImage,
}

impl Film {
    fn new(format: ImageFormat, layout: Layout) -> Self {
        let [color, albedo, normal] = images(SIZE[0], SIZE[1]);
        let scene = Scene::new(&frame(&[color, albedo, normal], Inputs::ALL), format, layout);
        let empty = vec![[0.0; 4]; (SIZE[0] * SIZE[1]) as usize];
        let wide = ImageFormat::Texture(Texture::Rgba32Float);
        let motion = GpuImage::new(&empty, SIZE, wide, Layout::default());
        let depth = GpuImage::new(&empty, SIZE, F32, Layout::packed_channels(SIZE[0], 1));
        Self { scene, motion, depth }
    }

    pub(super) fn in_buffers() -> Self {
        Self::new(F32, Layout::packed_rgba(SIZE[0]))
    }

    pub(super) fn write(&self, [color, albedo, normal, motion, depth]: &Contents) {
        self.scene.color.write(color);
        self.scene.albedo.as_ref().expect("there is one").write(albedo);
        self.scene.normal.as_ref().expect("there is one").write(normal);
        self.motion.write(motion);
        self.depth.write(depth);
    }

    /// A pass without motion.
    pub(super) fn alone(&self) -> PassDescriptor<'_> {
        self.scene.descriptor().input_scale(InputScale::Value(SCALE))
    }

    pub(super) fn descriptor(&self) -> PassDescriptor<'_> {
        self.alone().motion(self.motion.as_pass()).depth(self.depth.as_pass())
    }

    /// The pass's outputs for consecutive frames.
    fn run(&self, pass: &Pass, frames: &[Contents]) -> Vec<Vec<Pixel>> {
        frames.iter().map(|frame| self.next(pass, frame)).collect()
    }

    fn next(&self, pass: &Pass, frame: &Contents) -> Vec<Pixel> {
        self.write(frame);
        self.scene.output.read(|encoder| pass.encode(encoder))
    }
}

/// The outputs for a sequence of a new pass on a new film.
fn run(denoiser: &Denoiser, frames: &[Contents], with_motion: bool) -> Vec<Vec<Pixel>> {
    let film = Film::in_buffers();
    let descriptor = if with_motion { film.descriptor() } else { film.alone() };
    film.run(&denoiser.pass(&descriptor).expect("the images fit"), frames)
}

fn bits(pixels: &[Pixel]) -> Vec<[u32; 4]> {
    pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

pub(super) fn same(found: &[Pixel], expected: &[Pixel]) -> Result<(), String> {
    let differ = bits(found).into_iter().zip(bits(expected)).filter(|(a, b)| a != b).count();
    if differ == 0 { Ok(()) } else { Err(format!("{differ} pixels differ")) }
}

/// The reference's averages of denoised frames, each with its color and then its layers.
pub(super) fn averaged(denoised: &[Vec<Vec<Pixel>>], frames: &[Contents]) -> Vec<Vec<Image>> {
    let mut history: Option<reference::History> = None;
    let mut means = Vec::new();
    for (denoised, [_, albedo, normal, motion, depth]) in denoised.iter().zip(frames) {
        let [albedo, normal] = [albedo, normal].map(|pixels| cpu_image(pixels, SIZE));
        let denoised: Vec<_> = denoised.iter().map(|pixels| cpu_image(pixels, SIZE)).collect();
        let motion: Vec<_> = motion.iter().map(|&[x, y, ..]| [x, y]).collect();
        let depth: Vec<_> = depth.iter().map(|pixel| pixel[0]).collect();
        let frame = reference::Frame {
            denoised: &denoised[0],
            layers: &denoised[1..].iter().collect::<Vec<_>>(),
            motion: &motion,
            albedo: Some(&albedo),
            normal: Some(&normal),
            depth: Some(&depth),
            input_scale: SCALE,
        };
        let next = reference::accumulate(&frame, history.as_ref(), 8.0);
        let image = |k: usize| {
            let light =
                |past: &reference::Past| if k == 0 { past.color } else { past.layers[k - 1] };
            let pixels = next.0.iter().map(|past| light(past).map(|v| v as f32)).collect();
            Image::new(SIZE[0], SIZE[1], pixels).expect("the count is right")
        };
        means.push((0..denoised.len()).map(image).collect());
        history = Some(next);
    }
    means
}

/// As for the operator, but albedo and normals have 32 bits: the mean of nine may round to the
/// adjacent step, which changes its difference by 1/3 · 1/255.
pub(super) const TOLERANCE: Tolerance = Tolerance { absolute: 1e-4, relative: 1e-3 };

#[test]
fn a_pass_with_motion_averages_what_one_without_denoises() {
    let frames = sequence(4);
    let cases = [0.0_f32, 0.25].into_iter().flat_map(|blend| [true, false].map(|s| (blend, s)));
    run_cases(cases, |&(blend, skips)| {
        let denoiser = denoiser(&Options::default().skip_clean(skips));
        let film = Film::in_buffers();
        let run = |descriptor: &PassDescriptor<'_>| {
            let pass = denoiser.pass(descriptor).expect("the images fit");
            pass.set_blend(blend);
            film.run(&pass, &frames)
        };
        let (alone, found) = (run(&film.alone()), run(&film.descriptor()));
        let denoised: Vec<_> = alone.iter().map(|color| vec![color.clone()]).collect();
        let expected = averaged(&denoised, &frames);
        let change = change(&alone[3], &found[3]);
        if change < 1e-3 {
            return Err(format!("the frames before change only {change}"));
        }
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let found = image_tensor(&cpu_image(found, SIZE));
            compare(&found, &image_tensor(&expected[0]), TOLERANCE)
                .map_err(|e| format!("{i}: {e}"))?;
        }
        let alphas = |pixels: &[Pixel]| pixels.iter().map(|pixel| pixel[3]).collect::<Vec<_>>();
        if alphas(&found[3]) == alphas(&frames[3][0]) { Ok(()) } else { Err("alpha".into()) }
    });
}

/// The mean relative change of a color.
fn change(a: &[Pixel], b: &[Pixel]) -> f32 {
    let of = |(a, b): (&Pixel, &Pixel)| (a[0] - b[0]).abs() / a[0].abs().max(0.1);
    a.iter().zip(b).map(of).sum::<f32>() / a.len() as f32
}

#[test]
fn tiles_make_the_same_bits() {
    let frames = sequence(3);
    for weights in [crate::support::tiny(), tiny_kernels()] {
        let [whole, tiled] = [None, Some(80)]
            .map(|tile| run(&denoiser_of(&weights, &Options::default().tile(tile)), &frames, true));
        run_cases(0..3, |&i| same(&tiled[i], &whole[i]));
    }
}

#[test]
fn without_a_history_a_frame_is_as_without_motion() {
    let frames = sequence(3);
    let denoiser = denoiser(&Options::default());
    let alone = run(&denoiser, &frames, false);
    run_cases([0.0, -1.0, f32::NAN], |&longest| {
        let film = Film::in_buffers();
        let pass = denoiser.pass(&film.descriptor()).expect("the images fit");
        pass.set_history(longest);
        let found = film.run(&pass, &frames);
        (0..3).try_for_each(|i| same(&found[i], &alone[i]))
    });
    let motion = run(&denoiser, &frames, true);
    same(&motion[0], &alone[0]).unwrap();
    same(&motion[1], &alone[1]).unwrap_err();
}

#[test]
fn a_longer_history_counts_more() {
    let frames = sequence(4);
    let denoiser = denoiser(&Options::default());
    let alone = run(&denoiser, &frames, false);
    let changes = [0.5, 2.0, f32::INFINITY].map(|longest| {
        let film = Film::in_buffers();
        let pass = denoiser.pass(&film.descriptor()).expect("the images fit");
        pass.set_history(longest);
        change(&film.run(&pass, &frames)[3], &alone[3])
    });
    assert!(changes[0] < 0.8 * changes[1] && changes[1] < 0.95 * changes[2], "{changes:?}");
}

#[test]
fn after_a_reset_the_next_frame_is_the_first() {
    let frames = sequence(5);
    let denoiser = denoiser(&Options::default());
    let fresh = run(&denoiser, &frames[2..], true);
    let film = Film::in_buffers();
    let pass = denoiser.pass(&film.descriptor()).expect("the images fit");
    film.run(&pass, &frames[..2]);
    pass.reset_history();
    let found = film.run(&pass, &frames[2..]);
    run_cases(0..3, |&i| same(&found[i], &fresh[i]));
}

#[test]
fn an_encoder_that_is_never_submitted_leaves_no_trace() {
    let frames = sequence(3);
    let denoiser = denoiser(&Options::default());
    let expected = run(&denoiser, &frames, true);
    let film = Film::in_buffers();
    let pass = denoiser.pass(&film.descriptor()).expect("the images fit");
    let device = &wgdenoise_testing::gpu::gpu().device;
    run_cases(0..3, |&i| {
        let mut encoder = device.create_command_encoder(&Default::default());
        pass.encode(&mut encoder);
        drop(encoder);
        let mut encoder = device.create_command_encoder(&Default::default());
        pass.encode(&mut encoder);
        drop(encoder.finish());
        same(&film.next(&pass, &frames[i]), &expected[i])
    });
}

#[test]
fn two_passes_have_histories_of_their_own() {
    let frames = sequence(6);
    let denoiser = denoiser(&Options::default());
    let expected = [&frames[..3], &frames[3..]].map(|frames| run(&denoiser, frames, true));
    let films = [(); 2].map(|()| Film::in_buffers());
    let passes =
        films.each_ref().map(|film| denoiser.pass(&film.descriptor()).expect("the images fit"));
    for i in 0..3 {
        for (k, film) in films.iter().enumerate() {
            let found = film.next(&passes[k], &frames[3 * k + i]);
            same(&found, &expected[k][i]).unwrap();
        }
    }
}

/// In the left half, the last frame shows another surface, or the surface was outside the image.
#[test]
fn where_a_surface_was_hidden_the_frame_stands_alone() {
    type Change = fn(&mut Contents, usize);
    let cases: [(&str, Change); 6] = [
        ("albedo", |frame, i| frame[1][i] = [1.0; 4]),
        ("normal", |frame, i| frame[2][i] = frame[2][i].map(|v| if v > 0.0 { -1.0 } else { 1.0 })),
        ("depth", |frame, i| frame[4][i] = [11.0; 4]),
        ("no hit", |frame, i| frame[4][i] = [f32::INFINITY; 4]),
        ("no motion", |frame, i| frame[3][i][1] = f32::NAN),
        ("out of the picture", |frame, i| frame[3][i][0] = -46.0),
    ];
    let denoiser = denoiser(&Options::default());
    run_cases(cases, |(_, change)| {
        let mut frames = sequence(2);
        // Constant features, so that the 3×3 means change as much as the pixels.
        for frame in &mut frames {
            frame[1].fill([0.4; 4]);
            frame[2].fill([0.5; 4]);
        }
        for i in (0..90 * 70).filter(|i| i % 90 < 45) {
            change(&mut frames[1], i);
        }
        let [alone, found] = [false, true].map(|motion| run(&denoiser, &frames, motion).remove(1));
        // The last columns of the half see both sides in their 3×3 pixels.
        let is_alone = |i: &usize| bits(&found[*i..=*i]) == bits(&alone[*i..=*i]);
        let count = |from: usize, to: usize| {
            let columns = (0..90 * 70).filter(|i| (from..to).contains(&(i % 90)));
            columns.filter(is_alone).count()
        };
        match (count(0, 44), count(47, 90)) {
            (3080, right) if right < 300 => Ok(()),
            (left, right) => Err(format!("alone: {left} of 3080 pixels, and {right} of 3010")),
        }
    });
}

/// Selects one of a film's images.
type Place = fn(&Film) -> &GpuImage;

/// The output overwrites an image that averaging reads around each pixel.
#[test]
fn the_output_may_be_any_of_the_inputs() {
    let frames = sequence(3);
    let denoiser = denoiser(&Options::default().tile(80));
    let float = (ImageFormat::Texture(Texture::Rgba32Float), Layout::default());
    let packed = (F32, Layout::packed_rgba(90));
    let places: [(&str, Place); 4] = [
        ("color", |film| &film.scene.color),
        ("albedo", |film| film.scene.albedo.as_ref().expect("there is one")),
        ("normal", |film| film.scene.normal.as_ref().expect("there is one")),
        ("motion", |film| &film.motion),
    ];
    let cases = places.into_iter().flat_map(|place| [float, packed].map(|format| (place, format)));
    run_cases(cases, |&((_, place), (format, layout))| {
        let film = Film::new(format, layout);
        let expected = denoiser.pass(&film.descriptor()).map_err(|e| e.to_string())?;
        let expected = film.run(&expected, &frames);
        let descriptor = film.descriptor().output(place(&film).as_pass());
        let pass = denoiser.pass(&descriptor).map_err(|e| e.to_string())?;
        (0..3).try_for_each(|i| {
            film.write(&frames[i]);
            same(&place(&film).read(|encoder| pass.encode(encoder)), &expected[i])
        })
    });
}

/// The history has 32 bits for any output format.
#[test]
fn outputs_of_16_bits_round_once() {
    let frames = sequence(4);
    let denoiser = denoiser(&Options::default());
    let film = Film::in_buffers();
    let expected = film.run(&denoiser.pass(&film.descriptor()).expect("the images fit"), &frames);
    let half = [
        (ImageFormat::Texture(Texture::Rgba16Float), Layout::default()),
        (ImageFormat::Buffer(Element::F16), Layout::packed_rgba(90)),
    ];
    run_cases(half, |&(format, layout)| {
        let output = GpuImage::new(&vec![[0.0; 4]; 90 * 70], SIZE, format, layout);
        let descriptor = film.descriptor().output(output.as_pass());
        let pass = denoiser.pass(&descriptor).map_err(|e| e.to_string())?;
        (0..4).try_for_each(|i| {
            film.write(&frames[i]);
            let found = output.read(|encoder| pass.encode(encoder));
            let pairs = found.as_flattened().iter().zip(expected[i].as_flattened());
            let is_off = |(a, b): &(&f32, &f32)| (*a - *b).abs() > b.abs() / 1024.0 + 1e-6;
            match pairs.filter(is_off).count() {
                0 => Ok(()),
                count => Err(format!("{count} values of frame {i} are off")),
            }
        })
    });
}
