//! Full resolution: a kernel pyramid's kernels that read the noisy color, in every format, and the
//! one that stores the image.

use wgdenoise::internals::model::Encoding;
use wgdenoise::internals::ops::activity::Activity;
use wgdenoise::internals::ops::channel_map::ChannelMap;
use wgdenoise::internals::ops::contrast::Contrast;
use wgdenoise::internals::ops::gather::{gather_albedo, gather_finest};
use wgdenoise::internals::ops::need::everything;
use wgdenoise::internals::ops::output_process::ResultImages;
use wgdenoise::internals::ops::pyramid::{NoisyColor, pyramid_finest, pyramid_level0};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Light, Repaired, Tensor};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{Element, Image, ImageFormat, Precision, TransferFunction};

use super::gather::{self, Level};
use super::image::{binding, view};
use wgdenoise_testing::gpu::{buffer, context, download, read_back, stored, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// As for a level, plus the mean of up to 24 pixels that fills a missing one.
const TOLERANCE: Tolerance =
    Tolerance { absolute: 1e-5, relative: 2.0 * gather::TOLERANCE.relative };

/// Multiplication by the texture is off by an exponential's error, 9 units in the last place, and
/// by up to 3 times the power's, 16 units of 1. A dark value among brighter ones is off by a share
/// of those, which the texture multiplies by up to 21.
const DEMODULATED: Tolerance = Tolerance {
    absolute: 21.0 * TOLERANCE.absolute,
    relative: TOLERANCE.relative + (9.0 + 3.0 * 16.0) * f32::EPSILON,
};

/// Formats of the color, each with a precision of the logits. Every pair compiles five kernels.
const FORMATS: [(ImageFormat, Precision); 4] = [
    (ImageFormat::Buffer(Element::F32), Precision::F32),
    (ImageFormat::Buffer(Element::F16), Precision::F16),
    (ImageFormat::Texture(Texture::Rgba16Float), Precision::F16),
    (ImageFormat::Texture(Texture::Rgba32Float), Precision::F32),
];

/// Width and height: one pixel, a few blocks, and room for a hole so large that even some pixels of
/// level 1 cannot be filled.
const SIZES: [[u32; 2]; 3] = [[1, 1], [13, 20], [50, 39]];

const ENCODING: Encoding = Encoding {
    gathered: true,
    unbounded: false,
    zero_padding: false,
    transfer_function: TransferFunction::Pu,
};

const INPUT_SCALE: f32 = 0.5;

#[test]
fn levels_0_and_1_equal_the_reference_in_every_format_with_holes() {
    let mut weightless = [0; 2];
    run_cases(cases(), |&case| {
        let scene = Scene::new(case);
        let expected =
            [scene.finest(), reference::pyramid(&scene.finest(), &scene.levels[1].logits)];
        for (l, expected) in expected.iter().enumerate() {
            weightless[l] += expected.pixels.iter().filter(|pixel| pixel[3] == 0.0).count();
            compare(&scene.run_level(l), &Level::light_of(expected), scene.tolerance())?;
        }
        Ok(())
    });
    assert!(weightless.iter().all(|&count| count > 100), "{weightless:?} pixels without weight");
}

#[test]
fn the_image_equals_the_reference_in_every_format_with_holes() {
    let mut black = 0;
    run_cases(cases(), |&case| {
        let scene = Scene::new(case);
        let coarser = scene.coarser();
        let expected = scene.image(&coarser);
        black += expected.pixels().iter().filter(|pixel| **pixel == [0.0; 3]).count();
        for stored in [false, true] {
            let found = scene.store_image(&coarser, stored);
            compare(&image_tensor(&found), &image_tensor(&expected), scene.tolerance())
                .map_err(|error| format!("level 0 stored: {stored}: {error}"))?;
        }
        Ok(())
    });
    assert!(black > 100, "{black} pixels have nothing to be gathered from");
}

/// A size, the color's format, the logits' precision, and whether the network demodulates.
type Case = ([u32; 2], ImageFormat, Precision, bool);

fn cases() -> impl Iterator<Item = Case> {
    let kinds =
        FORMATS.into_iter().flat_map(|kind| [false, true].map(|demodulates| (kind, demodulates)));
    let kinds: Vec<_> = kinds.collect();
    SIZES.into_iter().flat_map(move |size| {
        let case = move |((format, precision), demodulates)| (size, format, precision, demodulates);
        kinds.clone().into_iter().map(case)
    })
}

/// A noisy color with missing pixels, and the logits of two levels.
struct Scene {
    pixels: Vec<Pixel>,
    format: ImageFormat,
    /// The color as stored in the format.
    color: Image,
    repaired: Repaired,
    levels: [Level; 2],
    precision: Precision,
    /// The contrast of a textured albedo, with its values.
    contrast: Option<(Contrast, Tensor)>,
}

impl Scene {
    fn new((size, format, precision, demodulates): Case) -> Self {
        let mut random = Random::new(u64::from(size[0]));
        let pixels = pixels(&mut random, size);
        let color = cpu_image(&quantized(&pixels, format), size);
        let repaired = reference::repair_in(ENCODING, &color, INPUT_SCALE);
        let [width, height] = size.map(|side| side.next_multiple_of(16) as usize);
        let [fine, coarse] =
            [([height, width], 11 + usize::from(demodulates)), ([height / 2, width / 2], 11)];
        let mut levels = [fine, coarse]
            .map(|(size, logits)| Level::logits(&mut random, logits, size, precision));
        // Scaled to give powers of all sizes.
        levels[0].logits.data[11 * height * width..].iter_mut().for_each(|v| *v *= 0.05);
        levels[0].logits = stored(&levels[0].logits, precision);
        let contrast = demodulates.then(|| textured(&mut random, &levels));
        Self { pixels, format, color, repaired, levels, precision, contrast }
    }

    fn texture(&self) -> Vec<[f64; 3]> {
        let contrast = self.contrast.as_ref().map(|(_, values)| values);
        reference::texture(contrast, &self.levels[0].logits)
    }

    fn tolerance(&self) -> Tolerance {
        if self.contrast.is_some() { DEMODULATED } else { TOLERANCE }
    }

    fn finest(&self) -> Light {
        let Repaired { color, valid } = &self.repaired;
        reference::finest(color, valid, &self.levels[0].logits)
    }

    /// The result of level 1, treated as the coarsest.
    fn coarser(&self) -> Level {
        let logits = &self.levels[1].logits;
        let level = reference::pyramid(&self.finest(), logits);
        let light = Level::light_of(&reference::gather(&level, logits, None));
        Level { light, ..self.levels[1].clone() }
    }

    /// The image, with the noisy color in the first block.
    fn image(&self, coarser: &Level) -> Image {
        let (logits, coarser) = (&self.levels[0].logits, coarser.premultiplied());
        let light = reference::gather(&self.finest(), logits, Some(&coarser));
        let light = Level::light_of(&reference::modulated(&light, &self.texture()));
        let (width, height) = self.color.size();
        let at =
            |i: u32| [0, 1, 2].map(|c| light.at(c, (i / width) as usize, (i % width) as usize));
        let image = Image::new(width, height, (0..width * height).map(at).collect());
        let columns = width.div_ceil(16) as usize;
        reference::keep_clean(image.unwrap(), &self.color, &self.clean(), columns)
    }

    /// Only the first block is clean, if there are more than two; it has no missing pixels.
    fn clean(&self) -> Vec<bool> {
        let (width, height) = self.color.size();
        let blocks = width.div_ceil(16) * height.div_ceil(16);
        (0..blocks).map(|block| block == 0 && blocks > 2).collect()
    }

    /// The kernel's output for level 0, or for level 1 if level 0 is not stored.
    fn run_level(&self, l: usize) -> Tensor {
        let context = context(self.precision);
        let logits = self.levels.each_ref().map(Level::upload_logits);
        let output = self.levels[l].upload_light();
        self.with_color(|noisy| {
            let call = match l {
                0 => pyramid_level0(context, noisy, &logits[0], &output),
                _ => pyramid_finest(context, noisy, [&logits[0], &logits[1]], &output),
            };
            submit(context, |pass| call.record_at(pass, 0));
        });
        Level::download(&output)
    }

    /// The kernel's output image; with level 0 `stored`, it reads that.
    fn store_image(&self, coarser: &Level, stored: bool) -> Image {
        let context = context(self.precision);
        let flags: Vec<_> = self.clean().into_iter().map(u32::from).collect();
        let clean = buffer(context, bytemuck::cast_slice(&flags));
        let activity = Activity { map: everything(&context.device), clean };
        let level0 = Level { light: Level::light_of(&self.finest()), ..self.levels[0].clone() };
        let level0 = stored.then(|| level0.upload_light());
        let [logits, coarser] = [self.levels[0].upload_logits(), coarser.upload_light()];
        let (width, height) = self.color.size();
        let output = buffer(context, &vec![0xff; (width * height * 12) as usize]);
        self.with_color(|&NoisyColor { tiles, color, input_scale, encoding }| {
            let (output, blend) = ((&output).into(), &buffer(context, &[0; 4]));
            let images = ResultImages { tiles, input_scale, color, output, blend, encoding };
            let (tensors, level0) = ([&logits, &coarser], level0.as_ref());
            let contrast = self.contrast.as_ref().map(|(contrast, _)| contrast);
            let call = gather_finest(context, tensors, level0, contrast, &activity, &images);
            submit(context, |pass| call.record_at(pass, 0));
        });
        let bytes = read_back(context, output.size(), |encoder, target| {
            encoder.copy_buffer_to_buffer(&output, 0, target, 0, output.size());
        });
        Image::new(width, height, bytemuck::pod_collect_to_vec(&bytes)).expect("the count is right")
    }

    /// Calls `run` with the color on the GPU as a single tile.
    fn with_color(&self, run: impl FnOnce(&NoisyColor<'_>)) {
        let context = context(self.precision);
        let (width, height) = self.color.size();
        let (size, layout) = ([width, height], Layout::packed(width));
        let image = GpuImage::new(&self.pixels, size, self.format, layout);
        let pass_image = image.as_pass();
        let tile =
            Tile { image_size: size, end: size, color: layout, output: layout, ..Tile::default() };
        run(&NoisyColor {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            color: binding(&pass_image, view(&pass_image).as_ref()),
            input_scale: &buffer(context, bytemuck::bytes_of(&INPUT_SCALE)),
            encoding: ENCODING,
        });
    }
}

/// The contrast of random albedo, and its values as stored.
fn textured(random: &mut Random, [fine, coarse]: &[Level; 2]) -> (Contrast, Tensor) {
    let context = context(fine.precision);
    let mut albedo = |level: &Level| {
        let size = [level.logits.height, level.logits.width];
        let mut light = Level::random(random, size, Precision::F32);
        light.light.data[..3 * size[0] * size[1]].iter_mut().for_each(|v| *v *= 0.5);
        light.upload_light()
    };
    let (level0, coarser) = (albedo(fine), albedo(coarse));
    let output = Contrast::new(context, [level0.width, level0.height]);
    let call = gather_albedo(context, [&level0, &fine.upload_logits()], &coarser, &output);
    submit(context, |pass| call.record(pass));
    let map = ChannelMap::from([Some(0), Some(1), Some(2), None]);
    let values = download(context, &output.tensor, &map);
    (output, values)
}

/// Positive light with outliers, single bad pixels and a large hole, all outside the first block.
fn pixels(random: &mut Random, [width, height]: [u32; 2]) -> Vec<Pixel> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e4];
    let mut pixel = |i: u32| {
        let [x, y] = [i % width, i / width];
        let [r, g, b] = [0; 3].map(|_| random.value() * 0.8 + 1.0);
        match i % 37 {
            _ if (18..44).contains(&x) && (17..37).contains(&y) => [f32::NAN; 4],
            0 if x >= 16 || y >= 16 => [r, bad[(i / 37 % 4) as usize], b, 1.0],
            _ => [r, g, b, 1.0],
        }
    };
    (0..width * height).map(&mut pixel).collect()
}
