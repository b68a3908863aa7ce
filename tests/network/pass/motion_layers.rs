//! Layers of frames averaged along their motion.

use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{
    Denoiser, Element, Error, ImageFormat, Layout, Options, Pass, PassDescriptor, PassLayer,
};

use super::F32;
use super::motion::{Contents, Film, SIZE, TOLERANCE, averaged, same, sequence};
use crate::support::{denoiser_of, tiny_kernels};
use wgdenoise_testing::gpu::gpu;
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image};
use wgdenoise_testing::{Random, compare, image_tensor, run_cases};

const WIDTH: usize = SIZE[0] as usize;
const PIXELS: usize = WIDTH * SIZE[1] as usize;

/// Describes a pass with or without motion.
type Choose = fn(&Film) -> PassDescriptor<'_>;

/// A frame, and its layers.
type Layered = (Contents, Vec<Vec<Pixel>>);

/// The images of a pass with motion and layers, with an output per layer.
struct LayeredFilm {
    film: Film,
    layers: Vec<[GpuImage; 2]>,
}

impl LayeredFilm {
    fn new(layers: usize, format: ImageFormat, layout: Layout) -> Self {
        let image = || GpuImage::new(&vec![[0.0; 4]; PIXELS], SIZE, format, layout);
        let layers = (0..layers).map(|_| [image(), image()]).collect();
        Self { film: Film::in_buffers(), layers }
    }

    fn in_buffers(layers: usize) -> Self {
        Self::new(layers, F32, Layout::packed_rgba(SIZE[0]))
    }

    /// A pass as described by `choose`, plus the layers.
    fn pass(&self, denoiser: &Denoiser, choose: Choose) -> Pass {
        let layers = self
            .layers
            .iter()
            .map(|[noisy, output]| PassLayer::new(noisy.as_pass(), output.as_pass()));
        let layers: Vec<_> = layers.collect();
        denoiser.pass(&choose(&self.film).layers(&layers)).expect("the images fit")
    }

    /// The denoised color and layers of a frame.
    fn next(&self, pass: &Pass, (contents, layers): &Layered) -> Vec<Vec<Pixel>> {
        self.film.write(contents);
        for ([noisy, _], pixels) in self.layers.iter().zip(layers) {
            noisy.write(pixels);
        }
        let color = self.film.scene.output.read(|encoder| pass.encode(encoder));
        let layers = self.layers.iter().map(|[_, output]| output.read(|_| {}));
        [color].into_iter().chain(layers).collect()
    }

    fn run(&self, pass: &Pass, frames: &[Layered]) -> Vec<Vec<Vec<Pixel>>> {
        frames.iter().map(|frame| self.next(pass, frame)).collect()
    }
}

fn pyramid() -> Denoiser {
    denoiser_of(&tiny_kernels(), &Options::default())
}

/// The outputs for a sequence of a new pass on a new film.
fn run(denoiser: &Denoiser, frames: &[Layered], with_motion: bool) -> Vec<Vec<Vec<Pixel>>> {
    let film = LayeredFilm::in_buffers(frames[0].1.len());
    let pass = film.pass(denoiser, if with_motion { Film::descriptor } else { Film::alone });
    film.run(&pass, frames)
}

/// Frames, each with three light groups that add up to it, one of them negative in places. Content
/// moves by a third of a pixel, and the left shows a different surface in every other frame.
fn groups(count: usize) -> Vec<Layered> {
    let mut random = Random::new(77);
    let mut frames = sequence(count);
    for (k, frame) in frames.iter_mut().enumerate() {
        frame[3].fill([1.0 / 3.0, -0.25, 0.0, 0.0]);
        let hidden = (0..PIXELS).filter(|i| k % 2 == 1 && i % WIDTH < 20);
        hidden.for_each(|i| frame[4][i] = [50.0; 4]);
    }
    let layered = frames.into_iter().map(|contents| {
        let mut groups = vec![Vec::new(); 3];
        for color in &contents[0] {
            let parts = [0.4 + 0.4 * random.value(), 0.5 * random.value()];
            let [first, second] = parts.map(|share| color.map(|v| share * v));
            groups[2].push([0, 1, 2, 3].map(|c| color[c] - first[c] - second[c]));
            groups[0].push(first);
            groups[1].push(second);
        }
        (contents, groups)
    });
    layered.collect()
}

/// The largest value of a color within 8 pixels.
fn brightest(color: &[Pixel], i: usize) -> f32 {
    let near = |at: usize, side: usize| at.saturating_sub(8)..(at + 9).min(side);
    let rows = near(i / WIDTH, PIXELS / WIDTH);
    let pixels = rows.flat_map(|y| near(i % WIDTH, WIDTH).map(move |x| y * WIDTH + x));
    pixels.flat_map(|i| color[i][..3].to_vec()).fold(f32::MIN_POSITIVE, |a, v| a.max(v.abs()))
}

/// Maximum difference from the color, relative to the brightest pixel nearby: once as in a frame
/// that is denoised alone (`tests/network/layers.rs`), and once more for averaging frames
/// (`tests/ops/accumulate_layer.rs`).
const ROUNDING: f32 = 2e-5;

fn close(found: impl Fn(usize, usize) -> f32, color: &[Pixel]) -> Result<(), String> {
    let off = |i: usize| {
        let of = |c: usize| (found(i, c) - color[i][c]).abs();
        (0..3).map(of).fold(0.0, f32::max) / brightest(color, i)
    };
    let most = (0..PIXELS).map(off).fold(0.0, f32::max);
    if most < ROUNDING { Ok(()) } else { Err(format!("off by {most}")) }
}

#[test]
fn layers_are_averaged_by_the_weights_of_the_color() {
    let frames = groups(4);
    let contents: Vec<_> = frames.iter().map(|(contents, _)| contents.clone()).collect();
    run_cases(
        [None, Some(80)].into_iter().flat_map(|t| [(t, 0.0), (t, 0.25)]),
        |&(tile, blend)| {
            let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(tile));
            let run = |choose: Choose| {
                let film = LayeredFilm::in_buffers(3);
                let pass = film.pass(&denoiser, choose);
                pass.set_blend(blend);
                film.run(&pass, &frames)
            };
            let (alone, found) = (run(Film::alone), run(Film::descriptor));
            let expected = averaged(&alone, &contents);
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                for (l, (found, expected)) in found.iter().zip(expected).enumerate() {
                    let found = image_tensor(&cpu_image(found, SIZE));
                    compare(&found, &image_tensor(expected), TOLERANCE)
                        .map_err(|e| format!("frame {i}, image {l}: {e}"))?;
                }
            }
            let alphas = |pixels: &[Pixel]| pixels.iter().map(|pixel| pixel[3]).collect::<Vec<_>>();
            let kept = (0..3).all(|l| alphas(&found[3][l + 1]) == alphas(&frames[3].1[l]));
            if kept { Ok(()) } else { Err("alpha".into()) }
        },
    );
}

#[test]
fn light_groups_add_up_to_the_averaged_color() {
    let frames = groups(7);
    let film = LayeredFilm::in_buffers(3);
    let denoiser = pyramid();
    let pass = film.pass(&denoiser, Film::descriptor);
    let alone = run(&denoiser, &frames, false);
    run_cases(0..7, |&i| {
        // A cut.
        if i == 4 {
            pass.reset_history();
        }
        let found = film.next(&pass, &frames[i]);
        close(|p, c| (1..4).map(|l| found[l][p][c]).sum(), &found[0])?;
        let is_first = i == 0 || i == 4;
        let is_alone = (0..4).all(|l| same(&found[l], &alone[i][l]).is_ok());
        if is_first == is_alone { Ok(()) } else { Err("counts the wrong frames".into()) }
    });
}

#[test]
fn the_color_as_a_layer_is_the_color() {
    let frames: Vec<Layered> = groups(5)
        .into_iter()
        .map(|(f, mut layers)| (f.clone(), vec![layers.remove(0), f[0].clone()]))
        .collect();
    let found = run(&pyramid(), &frames, true);
    run_cases(0..5, |&i| close(|p, c| found[i][2][p][c], &found[i][0]));
}

#[test]
fn without_a_history_layers_are_as_without_motion() {
    let frames = groups(3);
    let denoiser = pyramid();
    let formats = [
        (F32, Layout::packed_rgba(90)),
        (ImageFormat::Buffer(Element::F16), Layout::new(3, 380, 4).with_alpha()),
        (ImageFormat::Texture(Texture::Rgba16Float), Layout::default()),
        (ImageFormat::Texture(Texture::Rgba32Float), Layout::default()),
    ];
    run_cases(formats, |&(format, layout)| {
        let films = [(); 2].map(|()| LayeredFilm::new(3, format, layout));
        let alone = films[0].pass(&denoiser, Film::alone);
        let pass = films[1].pass(&denoiser, Film::descriptor);
        pass.set_history(0.0);
        let [expected, found] =
            [films[0].run(&alone, &frames), films[1].run(&pass, &frames)].map(|all| all.concat());
        found.iter().zip(&expected).try_for_each(|(found, expected)| same(found, expected))
    });
}

/// The history has 32 bits for any output format.
#[test]
fn layers_of_16_bits_round_once() {
    let frames = groups(4);
    let denoiser = pyramid();
    let [wide, half] = [Texture::Rgba32Float, Texture::Rgba16Float].map(ImageFormat::Texture);
    let run = |output: ImageFormat| {
        let mut film = LayeredFilm::in_buffers(3);
        for [_, image] in &mut film.layers {
            *image = GpuImage::new(&vec![[0.0; 4]; PIXELS], SIZE, output, Layout::default());
        }
        film.run(&film.pass(&denoiser, Film::descriptor), &frames).concat()
    };
    let (found, expected) = (run(half).concat(), run(wide).concat());
    let pairs = found.as_flattened().iter().zip(expected.as_flattened());
    // Drivers may truncate.
    let is_off = |(a, b): &(&f32, &f32)| (*a - *b).abs() > b.abs() / 1024.0 + 1e-6;
    assert_eq!(pairs.filter(is_off).count(), 0);
    assert_ne!(found, expected);
}

#[test]
fn tiles_make_the_same_bits_of_layers() {
    let frames = groups(3);
    let [whole, tiled] = [None, Some(80)].map(|tile| {
        let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(tile));
        run(&denoiser, &frames, true).concat()
    });
    run_cases(0..12, |&i| same(&tiled[i], &whole[i]));
}

#[test]
fn after_a_reset_layers_start_anew_and_a_dropped_encoder_leaves_no_trace() {
    let frames = groups(5);
    let denoiser = pyramid();
    let expected = run(&denoiser, &frames[2..], true).concat();
    let film = LayeredFilm::in_buffers(3);
    let pass = film.pass(&denoiser, Film::descriptor);
    film.run(&pass, &frames[..2]);
    pass.reset_history();
    let found = frames[2..].iter().map(|frame| {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        pass.encode(&mut encoder);
        drop(encoder.finish());
        film.next(&pass, frame)
    });
    let found: Vec<_> = found.collect::<Vec<_>>().concat();
    run_cases(0..12, |&i| same(&found[i], &expected[i]));
}

/// In textures and buffers, one layer overwrites itself, and one overwrites the motion, which later
/// layers read.
#[test]
fn outputs_of_averaged_layers_may_be_inputs() {
    let frames = groups(3);
    let denoiser = denoiser_of(&tiny_kernels(), &Options::default().tile(80));
    let wide = ImageFormat::Texture(Texture::Rgba32Float);
    let cases = [(wide, Layout::default()), (F32, Layout::packed_rgba(90))];
    run_cases(cases, |&(format, layout)| {
        let expected = LayeredFilm::new(2, format, layout);
        let expected = expected.run(&expected.pass(&denoiser, Film::descriptor), &frames);
        let LayeredFilm { film, layers } = LayeredFilm::new(2, format, layout);
        let places = [&film.motion, &layers[1][0]];
        let bound = [0, 1].map(|l| PassLayer::new(layers[l][0].as_pass(), places[l].as_pass()));
        let pass = denoiser.pass(&film.descriptor().layers(&bound)).map_err(|e| e.to_string())?;
        for ((contents, noisy), expected) in frames.iter().zip(&expected) {
            film.write(contents);
            layers.iter().zip(noisy).for_each(|([image, _], pixels)| image.write(pixels));
            same(&film.scene.output.read(|encoder| pass.encode(encoder)), &expected[0])?;
            same(&places[0].read(|_| {}), &expected[1])?;
            same(&places[1].read(|_| {}), &expected[2])?;
        }
        Ok(())
    });
}

/// 20 layers take 640 bytes per pixel, which is 4 MB.
#[test]
fn the_memory_of_layers_counts_against_the_budget() {
    let film = LayeredFilm::in_buffers(20);
    let options = Options::default().memory_bytes(4_000_000);
    let denoiser = denoiser_of(&tiny_kernels(), &options);
    let layers =
        film.layers.iter().map(|[noisy, out]| PassLayer::new(noisy.as_pass(), out.as_pass()));
    let layers: Vec<_> = layers.collect();
    denoiser.pass(&film.film.alone().layers(&layers)).expect("they own nothing");
    denoiser.pass(&film.film.descriptor().layers(&layers[..1])).expect("it fits");
    let error = denoiser.pass(&film.film.descriptor().layers(&layers)).unwrap_err();
    assert!(matches!(error, Error::Budget(_)), "{error}");
}
