//! Full resolution: a kernel pyramid's kernels that read the noisy color, in every format, and the
//! one that stores the image.

use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::Encoding;
use wgdenoise::internals::ops::activity::Activity;
use wgdenoise::internals::ops::gather::{Level0, gather_finest};
use wgdenoise::internals::ops::need::everything;
use wgdenoise::internals::ops::output_process::ResultImages;
use wgdenoise::internals::ops::pyramid::{NoisyColor, pyramid_finest, pyramid_level0};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Light, Repaired, Tensor};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{Element, Image, ImageFormat, Precision, TransferFunction};

use super::gather::{self, Level};
use super::image::{binding, view};
use wgdenoise_testing::gpu::{buffer, context, read_back, stored, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// As for a level, plus the mean of up to 24 pixels that fills a missing one.
const TOLERANCE: Tolerance =
    Tolerance { absolute: 1e-5, relative: 2.0 * gather::TOLERANCE.relative };

/// The ratio of albedos has a level's error relative to 0.05 or more. Its power adds an
/// exponential's error, 9 units in the last place, and up to 3 times the errors of the power, 16
/// units of 1, and of the logarithm, 4. A dark value among brighter ones is off by a share of those,
/// which the texture multiplies by up to 21.
const DEMODULATED: Tolerance = Tolerance {
    absolute: 21.0 * TOLERANCE.absolute,
    relative: 2.0 * TOLERANCE.relative
        + gather::TOLERANCE.absolute / 0.05
        + (9.0 + 3.0 * 20.0) * f32::EPSILON,
};

/// Formats of the color and of the albedo, with a precision of the logits. Every row compiles eight
/// kernels.
const FORMATS: [([ImageFormat; 2], Precision); 5] = [
    ([F32, F32], Precision::F32),
    ([F16, ImageFormat::Texture(Texture::Rgba8Unorm)], Precision::F16),
    ([ImageFormat::Texture(Texture::Rgba16Float), F16], Precision::F16),
    ([ImageFormat::Texture(Texture::Rgba32Float); 2], Precision::F32),
    ([F32, ImageFormat::Texture(Texture::Rgba16Float)], Precision::F16),
];

const F32: ImageFormat = ImageFormat::Buffer(Element::F32);
const F16: ImageFormat = ImageFormat::Buffer(Element::F16);

/// Width and height: one pixel, a few blocks, whole blocks, whose edges are the tile's, and room for
/// a hole so large that even some pixels of level 1 cannot be filled.
const SIZES: [[u32; 2]; 4] = [[1, 1], [13, 20], [32, 48], [50, 39]];

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
        for (l, weightless) in weightless.iter_mut().enumerate() {
            let expected = scene.level(l);
            let pixels = expected.width * expected.height;
            let weights = &expected.data[3 * pixels..4 * pixels];
            *weightless += weights.iter().filter(|weight| **weight == 0.0).count();
            let mut found = scene.run_level(l);
            if l == 1 {
                forget_weightless_albedo(&mut found);
            }
            compare(&found, &expected, TOLERANCE)?;
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
        let expected = scene.image();
        black += expected.pixels().iter().filter(|pixel| **pixel == [0.0; 3]).count();
        for stored in [false, true] {
            let found = scene.store_image(stored);
            compare(&image_tensor(&found), &image_tensor(&expected), scene.tolerance())
                .map_err(|error| format!("level 0 stored: {stored}: {error}"))?;
        }
        Ok(())
    });
    assert!(black > 100, "{black} pixels have nothing to be gathered from");
}

/// A size, the images' formats, the logits' precision, and whether the network demodulates.
type Case = ([u32; 2], [ImageFormat; 2], Precision, bool);

fn cases() -> impl Iterator<Item = Case> {
    let kinds =
        FORMATS.into_iter().flat_map(|kind| [false, true].map(|demodulates| (kind, demodulates)));
    let kinds: Vec<_> = kinds.collect();
    SIZES.into_iter().flat_map(move |size| {
        let case =
            move |((formats, precision), demodulates)| (size, formats, precision, demodulates);
        kinds.clone().into_iter().map(case)
    })
}

/// A noisy color with missing pixels, and the logits of two levels.
struct Scene {
    pixels: Vec<Pixel>,
    formats: [ImageFormat; 2],
    /// The color as stored in the format.
    color: Image,
    repaired: Repaired,
    levels: [Level; 2],
    precision: Precision,
    /// The albedo's pixels, and as the network sees it, if the network demodulates.
    albedo: Option<(Vec<Pixel>, Image)>,
}

impl Scene {
    fn new((size, formats, precision, demodulates): Case) -> Self {
        let mut random = Random::new(u64::from(size[0]));
        let pixels = pixels(&mut random, size);
        let color = cpu_image(&quantized(&pixels, formats[0]), size);
        let repaired = reference::repair_in(ENCODING, &color, INPUT_SCALE);
        let [width, height] = size.map(|side| side.next_multiple_of(16) as usize);
        let [fine, coarse] =
            [([height, width], 11 + usize::from(demodulates)), ([height / 2, width / 2], 11)];
        let mut levels = [fine, coarse]
            .map(|(size, logits)| Level::logits(&mut random, logits, size, precision));
        // Scaled to give powers of all sizes.
        levels[0].logits.data[11 * height * width..].iter_mut().for_each(|v| *v *= 0.05);
        levels[0].logits = stored(&levels[0].logits, precision);
        let albedo = demodulates.then(|| {
            let pixels = textured(&mut random, size, formats[1]);
            let seen = seen(&cpu_image(&quantized(&pixels, formats[1]), size));
            (pixels, seen)
        });
        Self { pixels, formats, color, repaired, levels, precision, albedo }
    }

    fn tolerance(&self) -> Tolerance {
        if self.albedo.is_some() { DEMODULATED } else { TOLERANCE }
    }

    /// What `result` makes of the color's and of the albedo's level 0, as the GPU stores it.
    fn like(&self, result: impl Fn(Light) -> Light) -> Tensor {
        let Repaired { color, valid } = &self.repaired;
        let of = |image| result(reference::finest(image, valid, &self.levels[0].logits));
        let color = Level::light_of(&of(color));
        match &self.albedo {
            Some((_, albedo)) => Level::joined(color, &of(albedo)),
            None => color,
        }
    }

    fn level(&self, l: usize) -> Tensor {
        let [finest, coarse] = self.levels.each_ref().map(|level| &level.logits);
        if l == 1 {
            return self.like(|level0| reference::pyramid(&level0, coarse));
        }
        let Repaired { color, valid } = &self.repaired;
        let color = Level::light_of(&reference::finest(color, valid, finest));
        let Some((_, albedo)) = &self.albedo else { return color };
        // A pixel keeps its albedo where its color is missing, since it is compared with others.
        Level::joined(color, &reference::finest(albedo, &vec![true; valid.len()], finest))
    }

    /// The result of level 1, treated as the coarsest.
    fn coarser(&self) -> Level {
        let logits = &self.levels[1].logits;
        let gathered =
            |level0| reference::gather(&reference::pyramid(&level0, logits), logits, None);
        Level { light: self.like(gathered), ..self.levels[1].clone() }
    }

    /// The image, with the noisy color in the first block.
    fn image(&self) -> Image {
        let logits = self.levels.each_ref().map(|level| level.logits.clone());
        let Repaired { color, valid } = &self.repaired;
        let albedo = self.albedo.as_ref().map(|(_, albedo)| albedo);
        let image = reference::kernel_pyramid(&logits, color, valid, albedo);
        let columns = self.color.width().div_ceil(16) as usize;
        reference::keep_clean(image, &self.color, &self.clean(), columns)
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
        let size = [logits[l].width, logits[l].height];
        let output = GpuTensor::light(context, size, 1 + u32::from(self.albedo.is_some()));
        self.with_images(|noisy| {
            let call = match l {
                0 => pyramid_level0(context, noisy, &logits[0], &output),
                _ => pyramid_finest(context, noisy, [&logits[0], &logits[1]], &output),
            };
            submit(context, |pass| call.record_at(pass, 0));
        });
        Level::download(&output)
    }

    /// The kernel's output image; with level 0 `stored`, it reads that.
    fn store_image(&self, stored: bool) -> Image {
        let context = context(self.precision);
        let flags: Vec<_> = self.clean().into_iter().map(u32::from).collect();
        let clean = buffer(context, bytemuck::cast_slice(&flags));
        let activity = Activity { map: everything(&context.device), clean };
        let level0 = Level { light: self.level(0), ..self.levels[0].clone() }.upload_light();
        let [logits, coarser] = [self.levels[0].upload_logits(), self.coarser().upload_light()];
        let (width, height) = self.color.size();
        let output = buffer(context, &vec![0xff; (width * height * 12) as usize]);
        self.with_images(|&NoisyColor { tiles, color, albedo, input_scale, encoding }| {
            let (output, blend) = ((&output).into(), &buffer(context, &[0; 4]));
            let images = ResultImages { tiles, input_scale, color, output, blend, encoding };
            let level0 = if stored { Level0::Stored(&level0) } else { Level0::Computed(albedo) };
            let call = gather_finest(context, level0, [&logits, &coarser], &activity, &images);
            submit(context, |pass| call.record_at(pass, 0));
        });
        let bytes = read_back(context, output.size(), |encoder, target| {
            encoder.copy_buffer_to_buffer(&output, 0, target, 0, output.size());
        });
        Image::new(width, height, bytemuck::pod_collect_to_vec(&bytes)).expect("the count is right")
    }

    /// Calls `run` with the images on the GPU as a single tile.
    fn with_images(&self, run: impl FnOnce(&NoisyColor<'_>)) {
        let context = context(self.precision);
        let (width, height) = self.color.size();
        let (size, layout) = ([width, height], Layout::packed(width));
        let albedo_layout = Layout::new(6, 3 * width + 3, 3);
        let color = GpuImage::new(&self.pixels, size, self.formats[0], layout);
        let albedo = self
            .albedo
            .as_ref()
            .map(|(pixels, _)| GpuImage::new(pixels, size, self.formats[1], albedo_layout));
        let (color, albedo) = (color.as_pass(), albedo.as_ref().map(GpuImage::as_pass));
        let albedo_view = albedo.as_ref().and_then(view);
        let tile = Tile {
            image_size: size,
            end: size,
            color: layout,
            albedo: albedo_layout,
            output: layout,
            ..Tile::default()
        };
        run(&NoisyColor {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            color: binding(&color, view(&color).as_ref()),
            albedo: albedo.as_ref().map(|albedo| binding(albedo, albedo_view.as_ref())),
            input_scale: &buffer(context, bytemuck::bytes_of(&INPUT_SCALE)),
            encoding: ENCODING,
        });
    }
}

/// Sets the albedo to 0 where it has no weight, because nothing depends on it there.
fn forget_weightless_albedo(level: &mut Tensor) {
    let pixels = level.width * level.height;
    let (color, albedo) = level.data.split_at_mut(4 * pixels);
    for (i, value) in albedo.iter_mut().enumerate() {
        *value *= f32::from(u8::from(color[3 * pixels + i % pixels] != 0.0));
    }
}

/// Random albedo with black columns and, in formats of floats, bad pixels.
fn textured(random: &mut Random, [width, height]: [u32; 2], format: ImageFormat) -> Vec<Pixel> {
    let is_float = !matches!(format, ImageFormat::Texture(Texture::Rgba8Unorm));
    let mut pixel = |i: u32| {
        let [r, g, b] = [0; 3].map(|_| random.value().abs());
        match (i % width % 5, i % 41) {
            (4, _) => [0.0, 0.0, 0.0, 1.0],
            (_, 20) if is_float => [r, f32::NAN, b, 1.0],
            (_, 30) if is_float => [r, g, f32::INFINITY, 1.0],
            (_, 40) if is_float => [6e4, -5.0, b, 1.0],
            _ => [r, g, b, 1.0],
        }
    };
    (0..width * height).map(&mut pixel).collect()
}

/// The albedo as the network sees it.
fn seen(albedo: &Image) -> Image {
    let (width, height) = albedo.size();
    let input = reference::input_process(albedo, Some(albedo), None, 1.0, 16);
    let pixel = |i: u32| [3, 4, 5].map(|c| input.at(c, (i / width) as usize, (i % width) as usize));
    Image::new(width, height, (0..width * height).map(pixel).collect()).expect("it is as large")
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
