//! The end of a network that predicts a kernel pyramid: the calls from its logits to the image and
//! its further layers.

use super::call::Call;
use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::tensor::GpuTensor;
use crate::ops::activity::Activity;
use crate::ops::demodulation;
use crate::ops::gather::{Level0, gather, gather_finest};
use crate::ops::image::ImageBinding;
use crate::ops::output_process::ResultImages;
use crate::ops::pyramid::{NoisyColor, pyramid, pyramid_finest, pyramid_layer0, pyramid_level0};

/// Bytes per pixel of a level's quad, in 32-bit floats.
const QUAD_BYTES: u64 = 16;

/// GPU memory in bytes for the pyramid of a tile and its results. The result of level 0 is the
/// image.
pub(crate) fn bytes(tile: [u32; 2], levels: usize, stores_level0: bool, demodulates: bool) -> u64 {
    let level = |l| tile.map(|side| u64::from(side >> l)).iter().product::<u64>();
    let level0 = if stores_level0 { level(0) } else { 0 };
    u64::from(quads(demodulates)) * QUAD_BYTES * (level0 + 2 * (1..levels).map(level).sum::<u64>())
}

fn quads(demodulates: bool) -> u32 {
    if demodulates { demodulation::QUADS } else { 1 }
}

/// The end of a network on one tile.
pub(super) struct Pyramid<'a> {
    context: &'a Context,
    /// By level.
    logits: Vec<&'a GpuTensor>,
    activity: &'a Activity,
    /// The albedo, if the network demodulates.
    albedo: Option<ImageBinding<'a>>,
    textures: Textures,
}

/// Textures for the pyramid and its results.
struct Textures {
    /// Absent if the calls compute it where they need it.
    level0: Option<GpuTensor>,
    /// From level 1 on.
    levels: Vec<GpuTensor>,
    results: Vec<GpuTensor>,
}

impl Textures {
    fn new(context: &Context, logits: &[&GpuTensor], stores_level0: bool, quads: u32) -> Self {
        let light =
            |logits: &GpuTensor| GpuTensor::light(context, [logits.width, logits.height], quads);
        let lights = || logits[1..].iter().copied().map(light).collect();
        Self {
            level0: stores_level0.then(|| light(logits[0])),
            levels: lights(),
            results: lights(),
        }
    }

    /// The same textures without the albedo.
    fn colors(&self) -> Self {
        let colors = |light: &[GpuTensor]| light.iter().map(GpuTensor::first_quad).collect();
        Self {
            level0: self.level0.as_ref().map(GpuTensor::first_quad),
            levels: colors(&self.levels),
            results: colors(&self.results),
        }
    }
}

impl<'a> Pyramid<'a> {
    /// Creates the textures. Layers need a stored level 0. With an `albedo`, light is demodulated.
    pub(super) fn new(
        context: &'a Context,
        logits: Vec<&'a GpuTensor>,
        activity: &'a Activity,
        stores_level0: bool,
        albedo: Option<ImageBinding<'a>>,
    ) -> Self {
        let textures = Textures::new(context, &logits, stores_level0, quads(albedo.is_some()));
        Self { context, logits, activity, albedo, textures }
    }

    /// The calls that store the image.
    pub(super) fn image(&self, images: &ResultImages<'_>) -> Vec<Call> {
        let textures = &self.textures;
        let mut calls = self.beginning(&self.noisy(images));
        calls.extend(self.levels_and_results(textures));
        let level0 = textures.level0.as_ref();
        let level0 = level0.map_or(Level0::Computed(self.albedo), Level0::Stored);
        calls.push(self.last(textures, level0, images));
        calls
    }

    /// The calls that store a further layer, the color of `images`, filtered with the same kernels.
    /// They come after those for the image, whose albedo they use if the layer `is_light`.
    /// `beauty` is the color that the network reads.
    ///
    /// # Panics
    /// Panics if level 0 is not stored.
    pub(super) fn layer(
        &self,
        images: &ResultImages<'_>,
        beauty: ImageBinding<'_>,
        is_light: bool,
    ) -> Vec<Call> {
        let colors = self.textures.colors();
        let mut calls = self.layer_beginning(&self.noisy(images), beauty, &colors);
        calls.extend(self.levels_and_results(&colors));
        let textures = if is_light { &self.textures } else { &colors };
        calls.push(self.last(textures, Level0::OfLayer(stored_level0(textures)), images));
        calls
    }

    /// How the pyramid reads the noisy color.
    fn noisy(&self, images: &ResultImages<'a>) -> NoisyColor<'a> {
        let ResultImages { tiles, color, input_scale, encoding, .. } = *images;
        NoisyColor { tiles, color, albedo: self.albedo, input_scale, encoding }
    }

    /// The last call. It reads the images if level 0 is not stored.
    fn last(&self, textures: &Textures, level0: Level0<'_>, images: &ResultImages<'_>) -> Call {
        let (logits, coarser) = (self.logits[0], &textures.results[0]);
        let dispatch =
            gather_finest(self.context, level0, [logits, coarser], self.activity, images);
        let call = Call::per_tile("gather0", dispatch);
        let (moved, touched) = match level0 {
            Level0::Computed(albedo) => {
                (vec![coarser], [images.color].into_iter().chain(albedo).collect())
            }
            Level0::Stored(level) | Level0::OfLayer(level) => (vec![coarser, level], Vec::new()),
        };
        let touched: Vec<_> = [images.output].into_iter().chain(touched).collect();
        call.moving(self.context, &[logits], &moved).touching(self.size(), &touched)
    }

    /// Full resolution, width first.
    fn size(&self) -> [u32; 2] {
        [self.logits[0].width, self.logits[0].height]
    }

    /// The calls from the noisy color to level 1.
    fn beginning(&self, noisy: &NoisyColor<'_>) -> Vec<Call> {
        let textures = &self.textures;
        let images: Vec<_> = [noisy.color].into_iter().chain(noisy.albedo).collect();
        if let Some(level0) = &textures.level0 {
            let call = pyramid_level0(self.context, noisy, self.logits[0], level0);
            return vec![self.first(call, level0, &images), self.level(1, level0, textures)];
        }
        let (logits, level1) = ([self.logits[0], self.logits[1]], &textures.levels[0]);
        let call = pyramid_finest(self.context, noisy, logits, level1);
        let [finest, own] = logits.map(confidences);
        let call = Call::per_tile("pyramid1", call);
        let call = call.moving(self.context, &[&finest, &own], &[level1]);
        vec![call.touching(self.size(), &images)]
    }

    /// The calls from a layer, in place of the noisy color, to level 1.
    fn layer_beginning(
        &self,
        noisy: &NoisyColor<'_>,
        beauty: ImageBinding<'_>,
        colors: &Textures,
    ) -> Vec<Call> {
        let level0 = stored_level0(colors);
        let call = pyramid_layer0(self.context, noisy, beauty, self.logits[0], level0);
        let first = self.first(call, level0, &[noisy.color, beauty]);
        vec![first, self.level(1, level0, colors)]
    }

    fn first(&self, dispatch: Dispatch, level0: &GpuTensor, images: &[ImageBinding<'_>]) -> Call {
        let confidences = confidences(self.logits[0]);
        let call = Call::per_tile("pyramid0", dispatch);
        let call = call.moving(self.context, &[&confidences], &[level0]);
        call.touching(self.size(), images)
    }

    /// The calls from level 1 to the coarsest, and back to the result of level 1.
    fn levels_and_results(&self, textures: &Textures) -> Vec<Call> {
        let count = self.logits.len();
        let down = (2..count).map(|l| self.level(l, &textures.levels[l - 2], textures));
        down.chain((1..count).rev().map(|l| self.result(l, textures))).collect()
    }

    /// The call that computes level `l` from the finer one.
    fn level(&self, l: usize, finer: &GpuTensor, textures: &Textures) -> Call {
        let (logits, level) = (self.logits[l], &textures.levels[l - 1]);
        let call = pyramid(self.context, finer, logits, level);
        let call = Call::fixed(&format!("pyramid{l}"), call);
        call.moving(self.context, &[&confidences(logits)], &[finer, level])
    }

    /// The call that computes the result of level `l`, from the coarser one if there is one.
    fn result(&self, l: usize, textures: &Textures) -> Call {
        let (level, result, coarser) =
            (&textures.levels[l - 1], &textures.results[l - 1], textures.results.get(l));
        let call = gather(self.context, [level, self.logits[l]], coarser, result);
        let moved: Vec<_> = [level, result].into_iter().chain(coarser).collect();
        let call = Call::fixed(&format!("gather{l}"), call);
        call.moving(self.context, &[self.logits[l]], &moved)
    }
}

fn stored_level0(textures: &Textures) -> &GpuTensor {
    textures.level0.as_ref().expect("there is one where there are layers")
}

/// The quad of logits that holds the confidence, the only one the pyramid reads, for counting
/// bytes.
fn confidences(logits: &GpuTensor) -> GpuTensor {
    GpuTensor { quads: 1, ..logits.clone() }
}
