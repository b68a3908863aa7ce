//! The albedo's contrast, computed from albedo in every format through a two-level pyramid.

use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::Encoding;
use wgdenoise::internals::ops::channel_map::ChannelMap;
use wgdenoise::internals::ops::contrast::Contrast;
use wgdenoise::internals::ops::gather::{gather, gather_albedo};
use wgdenoise::internals::ops::image::{Element, ImageBinding, ImageFormat};
use wgdenoise::internals::ops::pyramid::{NoisyColor, pyramid, pyramid_albedo0};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Repaired, Tensor};
use wgdenoise::wgpu::TextureFormat as Texture;
use wgdenoise::{Image, Precision, TransferFunction};

use super::gather::{self, Level};
use super::image::{binding, view};
use wgdenoise_testing::gpu::{PRECISIONS, buffer, context, download, submit};
use wgdenoise_testing::image::{GpuImage, Pixel, cpu_image, quantized};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// The gathered albedo has a level's error. Its logarithm, after adding 0.05, is off by that
/// relative to 0.05, plus 2⁻²¹ near 1, or three units in the last place for values of up to 4.
fn tolerance(precision: Precision) -> Tolerance {
    let Tolerance { absolute, relative } = gather::TOLERANCE;
    let absolute = 2.0 * (relative + absolute / 0.05) + 32.0 * f32::EPSILON / 2.0;
    // A store rounds by 2⁻¹¹ of the value, or by 2⁻²⁴ below 2⁻¹⁴.
    match precision {
        Precision::F32 => Tolerance { absolute, relative: 0.0 },
        Precision::F16 => Tolerance { absolute, relative: 1.0 / 1024.0 },
    }
}

const FORMATS: [ImageFormat; 5] = [
    ImageFormat::Buffer(Element::F32),
    ImageFormat::Buffer(Element::F16),
    ImageFormat::Texture(Texture::Rgba16Float),
    ImageFormat::Texture(Texture::Rgba32Float),
    ImageFormat::Texture(Texture::Rgba8Unorm),
];

const ENCODING: Encoding = Encoding {
    gathered: true,
    unbounded: false,
    zero_padding: false,
    transfer_function: TransferFunction::Pu,
};

#[test]
fn contrast_equals_the_reference_in_every_format_with_bad_pixels() {
    let cases = FORMATS.iter().flat_map(|format| PRECISIONS.map(|p| (*format, p)));
    run_cases(cases, |&(format, precision)| {
        let mut scene = Scene::new([37, 23], precision, 3);
        if !matches!(format, ImageFormat::Texture(Texture::Rgba8Unorm)) {
            scene.albedo[200][1] = f32::NAN;
            scene.albedo[300] = [0.5, 0.5, f32::INFINITY, 1.0];
            scene.albedo[400] = [6e4, -5.0, 0.5, 1.0];
        }
        // The color is missing in a square too large to be filled.
        (0..37 * 23).filter(|i| i % 37 < 12 && i / 37 < 12).for_each(|i| {
            scene.color[i] = [f32::NAN; 4];
        });
        let found = scene.run(format);
        let albedo = cpu_image(&quantized(&scene.albedo, format), scene.size);
        let expected = scene.expected(&albedo);
        compare(&found, &expected, tolerance(precision))?;
        let lit = Scene { color: vec![[1.0; 4]; 37 * 23], ..scene };
        compare(&found, &lit.expected(&albedo), tolerance(precision))
            .expect_err("missing color makes a difference");
        Ok(())
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn contrast_equals_the_reference_at_any_size(
        size in [1_u32..60, 1_u32..60],
        precision in sample::select(PRECISIONS.to_vec()),
        seed in any::<u64>(),
    ) {
        let scene = Scene::new(size, precision, seed);
        let expected = scene.expected(&cpu_image(&scene.albedo, size));
        let found = scene.run(ImageFormat::F32);
        compare(&found, &expected, tolerance(precision)).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn what_is_constant_has_exactly_no_contrast(
        size in [1_u32..40, 1_u32..40],
        color in [-0.5_f32..1.5, 0.0_f32..1.0, 0.0_f32..1e-3],
        seed in any::<u64>(),
    ) {
        let mut scene = Scene::new(size, Precision::F32, seed);
        scene.albedo.fill([color[0], color[1], color[2], 1.0]);
        let found = scene.run(ImageFormat::F32);
        prop_assert!(found.data.iter().all(|&v| v == 0.0), "{color:?}");
    }
}

/// One tile's images, and the logits of two levels.
struct Scene {
    size: [u32; 2],
    color: Vec<Pixel>,
    albedo: Vec<Pixel>,
    levels: [Level; 2],
    precision: Precision,
}

impl Scene {
    fn new(size: [u32; 2], precision: Precision, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let count = (size[0] * size[1]) as usize;
        let pixels = |random: &mut Random| {
            let mut pixel = |i: usize| {
                let [r, g, b] = [0; 3].map(|_| random.value().abs());
                // Black columns.
                if i % size[0] as usize % 5 == 4 { [0.0, 0.0, 0.0, 1.0] } else { [r, g, b, 1.0] }
            };
            (0..count).map(&mut pixel).collect::<Vec<_>>()
        };
        let (color, albedo) = (pixels(&mut random), pixels(&mut random));
        let [width, height] = size.map(|side| side.next_multiple_of(16) as usize);
        let levels = [(12, [height, width]), (10, [height / 2, width / 2])]
            .map(|(logits, size)| Level::logits(&mut random, logits, size, precision));
        Self { size, color, albedo, levels, precision }
    }

    fn expected(&self, albedo: &Image) -> Tensor {
        let color = cpu_image(&self.color, self.size);
        let Repaired { valid, .. } = reference::repair_in(ENCODING, &color, 1.0);
        let input = reference::input_process(albedo, Some(albedo), None, 1.0, 16);
        let width = self.size[0] as usize;
        let pixel = |i: usize| [3, 4, 5].map(|c| input.at(c, i / width, i % width));
        let pixels = (0..albedo.pixels().len()).map(pixel).collect();
        let seen = Image::new(self.size[0], self.size[1], pixels).expect("the size is the same");
        reference::contrast(&seen, &valid, &self.levels.each_ref().map(|l| l.logits.clone()))
    }

    fn run(&self, format: ImageFormat) -> Tensor {
        let context = context(self.precision);
        let width = self.size[0];
        let layouts = [Layout::packed(width), Layout::new(6, 3 * width + 3, 3)];
        let [color, albedo] = [(&self.color, ImageFormat::F32), (&self.albedo, format)];
        let images = [(color, layouts[0]), (albedo, layouts[1])]
            .map(|((pixels, format), layout)| GpuImage::new(pixels, self.size, format, layout));
        let images = images.each_ref().map(GpuImage::as_pass);
        let views = images.each_ref().map(view);
        let [color, albedo] = [0, 1].map(|i| binding(&images[i], views[i].as_ref()));
        let [color_layout, albedo_layout] = layouts;
        let tile = Tile {
            image_size: self.size,
            color: color_layout,
            albedo: albedo_layout,
            ..Tile::default()
        };
        let noisy = NoisyColor {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            color,
            input_scale: &buffer(context, bytemuck::bytes_of(&1_f32)),
            encoding: ENCODING,
        };
        let output = self.record(&noisy, albedo);
        let map = ChannelMap::from([Some(0), Some(1), Some(2), None]);
        download(context, &output.tensor, &map)
    }

    fn record(&self, noisy: &NoisyColor<'_>, albedo: ImageBinding<'_>) -> Contrast {
        let context = context(self.precision);
        let [logits0, logits1] = self.levels.each_ref().map(Level::upload_logits);
        let [level0, level1] = self.levels.each_ref().map(Level::upload_light);
        let result: GpuTensor = self.levels[1].upload_light();
        let output = Contrast::new(context, [level0.width, level0.height]);
        let first = pyramid_albedo0(context, noisy, albedo, &logits0, &level0);
        let rest = [
            pyramid(context, &level0, &logits1, &level1),
            gather(context, [&level1, &logits1], None, &result),
            gather_albedo(context, [&level0, &logits0], &result, &output),
        ];
        submit(context, |pass| {
            first.record_at(pass, 0);
            for call in &rest {
                call.record(pass);
            }
        });
        output
    }
}
