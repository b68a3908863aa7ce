use proptest::prelude::*;
use proptest::sample;
use wgdenoise::Precision;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::gather::gather;
use wgdenoise::internals::reference::{self, Light, Tensor};

use wgdenoise_testing::gpu::{PRECISIONS, context, download, stored, submit, upload};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// WGSL allows `exp(x)` an error of 3 + 2 |x| units in the last place: 19 for the largest weights,
/// 11 for typical odds. A mean of positive colors is off by at most the error of its weights, each
/// a product of two exponentials over a sum of such products; a dark color among brighter ones is
/// off by a share of those.
pub(crate) const TOLERANCE: Tolerance = Tolerance { absolute: 1e-6, relative: 1e-5 };

/// Rows and columns: single pixels, around the workgroup's 8, and elongated ones.
const CASES: [[usize; 2]; 5] = [[1, 1], [2, 2], [8, 8], [10, 18], [4, 40]];

#[test]
fn gather_equals_the_reference_with_and_without_a_coarser_level() {
    let kinds = PRECISIONS.into_iter().flat_map(|p| [false, true].map(|albedo| (p, albedo)));
    let cases = CASES.into_iter().flat_map(|size| kinds.clone().map(move |kind| (size, kind)));
    run_cases(cases, |&([height, width], kind)| {
        check([height, width], kind, false, 1)?;
        check([2 * height, 2 * width], kind, true, 1)
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn gather_equals_the_reference_at_any_size(
        [height, width] in [1_usize..20, 1_usize..20],
        (coarser, albedo, seed) in (any::<bool>(), any::<bool>(), any::<u64>()),
        precision in sample::select(PRECISIONS.to_vec()),
    ) {
        let size = [2 * height, 2 * width];
        check(size, (precision, albedo), coarser, seed).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn equal_pixels_stay_as_they_are_bit_for_bit(pixel in equal(), seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let mut level = Level::logits(&mut random, 11, [14, 18], Precision::F16);
        level.light = constant(&mut random, [14, 18], pixel).light;
        let coarser = constant(&mut random, [7, 9], pixel);
        let found = run(&level, Some(&coarser));
        prop_assert!(is_constant(&found, pixel), "{found:?}");
    }

    /// A weighted mean stays within the range of its inputs, however large colors and logits are.
    #[test]
    fn no_color_leaves_the_range_of_those_around(seed in any::<u64>(), scale in 0_i32..30) {
        let mut random = Random::new(seed);
        let mut level = Level::random(&mut random, [6, 6], Precision::F32);
        let factor = 10_f32.powi(scale);
        level.light.data[..3 * 36].iter_mut().for_each(|v| *v = (*v - 1.0) * factor);
        level.logits.data.iter_mut().for_each(|v| *v *= 30.0);
        let found = run(&level, None);
        let limit = |f: fn(f32, f32) -> f32, c: usize| {
            level.light.data[c * 36..][..36].iter().copied().reduce(f).expect("there are pixels")
        };
        for c in 0..3 {
            let (least, most) = (limit(f32::min, c), limit(f32::max, c));
            let values = &found.data[c * 36..][..36];
            prop_assert!(values.iter().all(|v| (least..=most).contains(v)), "{values:?}");
        }
    }
}

/// Bright light with little weight in this level meets dim light with much weight in the coarser
/// one: the bright part must be as exact as its weight.
#[test]
fn a_small_share_of_bright_light_is_exact() {
    let mut random = Random::new(11);
    for brightness in [1e3, 1e5, 1e7] {
        let mut level = Level::random(&mut random, [16, 16], Precision::F32);
        let (colors, weights) = level.light.data.split_at_mut(3 * 256);
        for v in colors {
            *v = (*v + 0.1) * brightness;
        }
        weights.fill(30.0 / brightness);
        let mut coarser = Level::random(&mut random, [8, 8], Precision::F32);
        coarser.light.data[3 * 64..].fill(1.0);
        let found = run(&level, Some(&coarser));
        compare(&found, &expected(&level, Some(&coarser)), TOLERANCE).unwrap();
    }
}

#[test]
fn a_wrong_logit_fails_the_comparison() {
    for channel in 0..11 {
        let mut random = Random::new(5);
        let mut level = Level::random(&mut random, [6, 6], Precision::F32);
        // Stays within the limits of confidence and share.
        level.logits.data[channel * 36 + 14] = 0.5;
        let mut coarser = Level::random(&mut random, [3, 3], Precision::F32);
        // Equal weights: if one outweighed all others, nothing else would matter.
        level.light.data[3 * 36..].fill(1.0);
        coarser.light.data[3 * 9..].fill(1.0);
        let expected = expected(&level, Some(&coarser));
        let mut wrong = level.clone();
        wrong.logits.data[channel * 36 + 14] += 0.01;
        let compared = compare(&run(&wrong, Some(&coarser)), &expected, TOLERANCE);
        // The confidence is applied by the pyramid, not here.
        assert_eq!(compared.is_err(), channel != 9, "channel {channel}");
    }
}

fn check(
    [height, width]: [usize; 2],
    (precision, has_albedo): (Precision, bool),
    has_coarser: bool,
    seed: u64,
) -> Result<(), String> {
    let mut random = Random::new(seed);
    let level = Level::random(&mut random, [height, width], precision);
    let coarser = Level::random(&mut random, [height.div_ceil(2), width.div_ceil(2)], precision);
    let [level, coarser] = [level, coarser]
        .map(|level| if has_albedo { level.with_albedo(&mut random) } else { level });
    let coarser = has_coarser.then_some(&coarser);
    compare(&run(&level, coarser), &expected(&level, coarser), TOLERANCE)
}

/// The albedo is gathered as if it were another color of the same weight.
fn expected(level: &Level, coarser: Option<&Level>) -> Tensor {
    level.like(|of| reference::gather(&of(level), &level.logits, coarser.map(of).as_ref()))
}

fn run(level: &Level, coarser: Option<&Level>) -> Tensor {
    let context = context(level.precision);
    let coarser = coarser.map(Level::upload_light);
    let (light, logits) = (level.upload_light(), level.upload_logits());
    let target = GpuTensor::light(context, [light.width, light.height], light.quads);
    let call = gather(context, [&light, &logits], coarser.as_ref(), &target);
    submit(context, |pass| call.record(pass));
    Level::download(&target)
}

/// A level of a kernel pyramid and its logits.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// `[4, h, w]`: a color, not premultiplied, and its weight. `[8, h, w]` with an albedo, whose
    /// fourth channel is 0.
    pub(crate) light: Tensor,
    pub(crate) logits: Tensor,
    pub(crate) precision: Precision,
}

impl Level {
    /// Colors in `[0, 2]`, weights over the whole range, logits in `[−4, 4]`.
    pub(crate) fn random(random: &mut Random, size: [usize; 2], precision: Precision) -> Self {
        let mut light = random.tensor(4, size[0], size[1]);
        let (colors, weights) = light.data.split_at_mut(3 * size[0] * size[1]);
        for v in colors {
            *v += 1.0;
        }
        for v in weights {
            *v = (*v * 20.0).exp();
        }
        Self { light, ..Self::logits(random, 11, size, precision) }
    }

    /// Logits as stored, some beyond the limits of confidence and share, with black light.
    pub(crate) fn logits(
        random: &mut Random,
        channels: usize,
        [height, width]: [usize; 2],
        precision: Precision,
    ) -> Self {
        let mut logits = random.tensor(channels, height, width);
        logits.data.iter_mut().for_each(|v| *v *= 4.0);
        logits.data[9 * height * width..].iter_mut().for_each(|v| *v *= 2.5);
        let logits = stored(&logits, precision);
        Self { logits, precision, ..Self::empty([height, width]) }
    }

    /// Black light and zero logits.
    pub(crate) fn empty([height, width]: [usize; 2]) -> Self {
        let zeros = |channels| Tensor::from_fn(channels, height, width, |_, _, _| 0.0);
        Self { light: zeros(4), logits: zeros(11), precision: Precision::F32 }
    }

    /// The level with an albedo from 0 to 1.
    pub(crate) fn with_albedo(mut self, random: &mut Random) -> Self {
        let Tensor { width, height, .. } = self.light;
        let albedo = random.tensor(3, height, width);
        self.light.data.extend(albedo.data.iter().map(|v| v.abs()));
        self.light.data.resize(8 * height * width, 0.0);
        self.light.channels = 8;
        self
    }

    pub(crate) fn premultiplied(&self) -> Light {
        self.premultiplied_from(0)
    }

    /// The albedo, times the color's weight.
    fn premultiplied_albedo(&self) -> Light {
        self.premultiplied_from(4)
    }

    /// The color in three channels from `first` on, times the weight.
    fn premultiplied_from(&self, first: usize) -> Light {
        let Tensor { width, height, .. } = self.light;
        let pixel = |i: usize| {
            let at = |c| f64::from(self.light.at(c, i / width, i % width));
            [at(first) * at(3), at(first + 1) * at(3), at(first + 2) * at(3), at(3)]
        };
        Light { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    /// The reference's result for the color and, if the level has one, for the albedo, as the GPU
    /// stores it.
    pub(crate) fn like(&self, result: impl Fn(fn(&Self) -> Light) -> Light) -> Tensor {
        let color = Self::light_of(&result(Self::premultiplied));
        if self.light.channels == 4 {
            return color;
        }
        Self::joined(color, &result(Self::premultiplied_albedo))
    }

    /// A color with an albedo of the same weight, as the GPU stores them.
    pub(crate) fn joined(mut color: Tensor, albedo: &Light) -> Tensor {
        let pixels = color.width * color.height;
        color.data.extend_from_slice(&Self::light_of(albedo).data[..3 * pixels]);
        color.data.resize(8 * pixels, 0.0);
        color.channels = 8;
        color
    }

    /// The reference's light as the GPU stores it: black where all weights are 0.
    pub(crate) fn light_of(light: &Light) -> Tensor {
        Tensor::from_fn(4, light.height, light.width, |c, y, x| {
            let pixel = light.at(x as i64, y as i64);
            let divisor = if c == 3 || pixel[3] == 0.0 { 1.0 } else { pixel[3] };
            (pixel[c] / divisor) as f32
        })
    }

    /// Light has 32 bits in both precisions.
    pub(crate) fn upload_light(&self) -> GpuTensor {
        upload(context(Precision::F32), &self.light, &channel_map(self.light.channels))
    }

    pub(crate) fn upload_logits(&self) -> GpuTensor {
        upload(context(self.precision), &self.logits, &channel_map(self.logits.channels))
    }

    pub(crate) fn download(light: &GpuTensor) -> Tensor {
        download(context(Precision::F32), light, &channel_map(4 * light.quads as usize))
    }
}

/// A color and an albedo, for levels of equal pixels.
pub(crate) type Equal = ([f32; 3], Option<[f32; 3]>);

/// Any color, with and without an albedo. Shaders may turn subnormal products into 0.
pub(crate) fn equal() -> impl Strategy<Value = Equal> {
    let is_normal = |v: &f32| *v == 0.0 || (1e-30..1e30).contains(&v.abs());
    let channel = any::<f32>().prop_filter("subnormal", is_normal);
    let color = [channel.clone(), channel.clone(), channel];
    (color, proptest::option::of([0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1e-3]))
}

/// A level of equal pixels, with weights over the whole range.
pub(crate) fn constant(random: &mut Random, size: [usize; 2], (color, albedo): Equal) -> Level {
    let mut level = Level::random(random, size, Precision::F32);
    if albedo.is_some() {
        level = level.with_albedo(random);
    }
    let channels = color.into_iter().enumerate();
    let of_albedo = albedo.into_iter().flatten().enumerate().map(|(c, value)| (c + 4, value));
    for (c, value) in channels.chain(of_albedo) {
        level.light.data[c * size[0] * size[1]..][..size[0] * size[1]].fill(value);
    }
    level
}

/// Whether a level's pixels are all this one, whatever their weights.
pub(crate) fn is_constant(light: &Tensor, (color, albedo): Equal) -> bool {
    let pixels = light.height * light.width;
    let channel = |c: usize| &light.data[c * pixels..][..pixels];
    let is_filled = |first: usize, color: [f32; 3]| {
        (0..3).all(|c| channel(first + c).iter().all(|&v| v == color[c]))
    };
    is_filled(0, color) && albedo.is_none_or(|albedo| is_filled(4, albedo))
}
