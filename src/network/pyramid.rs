//! The end of a network that predicts a kernel pyramid: the calls from its logits to the image and
//! its further layers.

use super::call::Call;
use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::tensor::GpuTensor;
use crate::ops::activity::Activity;
use crate::ops::contrast::Contrast;
use crate::ops::gather::{gather, gather_albedo, gather_finest, gather_layer};
use crate::ops::image::ImageBinding;
use crate::ops::output_process::ResultImages;
use crate::ops::pyramid::{
    NoisyColor, pyramid, pyramid_albedo0, pyramid_finest, pyramid_layer0, pyramid_level0,
};

/// Bytes per pixel: a color and its weight as 32-bit floats.
const PIXEL_BYTES: u64 = 16;

/// GPU memory in bytes for the pyramid of a tile and its results. The result of level 0 is the
/// image.
pub(crate) fn bytes(tile: [u32; 2], levels: usize, stores_level0: bool) -> u64 {
    let level = |l| tile.map(|side| u64::from(side >> l)).iter().product::<u64>();
    let level0 = if stores_level0 { level(0) } else { 0 };
    PIXEL_BYTES * (level0 + 2 * (1..levels).map(level).sum::<u64>())
}

/// The end of a network on one tile: the predicted logits, and textures for the pyramid and its
/// results.
pub(super) struct Pyramid<'a> {
    context: &'a Context,
    /// By level.
    logits: Vec<&'a GpuTensor>,
    activity: &'a Activity,
    /// The contrasts for light and for other layers, if the network demodulates.
    contrast: Option<[Contrast; 2]>,
    level0: Option<GpuTensor>,
    /// From level 1 on.
    levels: Vec<GpuTensor>,
    results: Vec<GpuTensor>,
}

impl<'a> Pyramid<'a> {
    /// Creates the textures. Layers need a stored level 0, and so does a pyramid that
    /// `demodulates`, for which the calls of [`albedo`](Self::albedo) come before all others.
    pub(super) fn new(
        context: &'a Context,
        logits: Vec<&'a GpuTensor>,
        activity: &'a Activity,
        stores_level0: bool,
        demodulates: bool,
    ) -> Self {
        let size = |l: usize| [logits[l].width, logits[l].height];
        let light = |l: usize| GpuTensor::light(context, size(l));
        let level0 = (stores_level0 || demodulates).then(|| light(0));
        let levels = (1..logits.len()).map(light).collect();
        let results = (1..logits.len()).map(light).collect();
        let contrast =
            demodulates.then(|| [Contrast::new(context, size(0)), Contrast::none(context)]);
        Self { context, logits, activity, contrast, level0, levels, results }
    }

    /// The calls that gather the albedo and store its contrast.
    ///
    /// # Panics
    /// Panics if the pyramid does not demodulate.
    pub(super) fn albedo(&self, noisy: &NoisyColor<'_>, albedo: ImageBinding<'_>) -> Vec<Call> {
        let level0 = self.level0.as_ref().expect("there is one where light is demodulated");
        let output = self.contrast_for(true).expect("light is demodulated");
        let call = pyramid_albedo0(self.context, noisy, albedo, self.logits[0], level0);
        let first = self.first(call, level0, &[noisy.color, albedo]);
        let mut calls = vec![first, self.level(1, level0)];
        calls.extend(self.levels_and_results());
        let (logits, coarser) = (self.logits[0], &self.results[0]);
        let last = gather_albedo(self.context, [level0, logits], coarser, output);
        let last = Call::fixed("gather0", last);
        calls.push(last.moving(self.context, &[logits, &output.tensor], &[level0, coarser]));
        calls.into_iter().map(|call| call.of("albedo")).collect()
    }

    /// The calls that store the image. With `reads_level0`, they store level 0 of the pyramid and
    /// read it; otherwise they compute it where they need it.
    pub(super) fn image(&self, images: &ResultImages<'_>, reads_level0: bool) -> Vec<Call> {
        let (level0, contrast) =
            (self.level0.as_ref().filter(|_| reads_level0), self.contrast_for(true));
        let noisy = noisy(images);
        let mut calls = match level0 {
            Some(level0) => self.stored_beginning(&noisy, level0),
            None => vec![self.computed_beginning(&noisy)],
        };
        calls.extend(self.levels_and_results());
        let inputs = self.last_inputs();
        let last = gather_finest(self.context, inputs, level0, contrast, self.activity, images);
        calls.push(self.last(last, level0, contrast, images));
        calls
    }

    /// The calls that store a further layer, the color of `images`, filtered with the same kernels
    /// and demodulated if it is `light`. `beauty` is the color that the network reads.
    ///
    /// # Panics
    /// Panics if there is no texture for level 0.
    pub(super) fn layer(
        &self,
        images: &ResultImages<'_>,
        beauty: ImageBinding<'_>,
        light: bool,
    ) -> Vec<Call> {
        let level0 = self.level0.as_ref().expect("there is one where there are layers");
        let contrast = self.contrast_for(light);
        let mut calls = self.layer_beginning(&noisy(images), beauty, level0);
        calls.extend(self.levels_and_results());
        let inputs = self.last_inputs();
        let last = gather_layer(self.context, inputs, level0, contrast, self.activity, images);
        calls.push(self.last(last, Some(level0), contrast, images));
        calls
    }

    /// The contrast that demodulates light, or the one that leaves other layers unchanged.
    fn contrast_for(&self, light: bool) -> Option<&Contrast> {
        self.contrast.as_ref().map(|[of_light, none]| if light { of_light } else { none })
    }

    fn last_inputs(&self) -> [&GpuTensor; 2] {
        [self.logits[0], &self.results[0]]
    }

    /// The last call. It reads the noisy color if level 0 is not stored.
    fn last(
        &self,
        dispatch: Dispatch,
        level0: Option<&GpuTensor>,
        contrast: Option<&Contrast>,
        images: &ResultImages<'_>,
    ) -> Call {
        let light: Vec<_> = [&self.results[0]].into_iter().chain(level0).collect();
        let call = Call::per_tile("gather0", dispatch);
        let call = call.moving(self.context, &read(self.logits[0], contrast), &light);
        let color = level0.is_none().then_some(images.color);
        let touched: Vec<_> = [images.output].into_iter().chain(color).collect();
        call.touching(self.size(), &touched)
    }

    /// Full resolution, width first.
    fn size(&self) -> [u32; 2] {
        [self.logits[0].width, self.logits[0].height]
    }

    /// The call from the noisy color to level 1, without storing level 0.
    fn computed_beginning(&self, noisy: &NoisyColor<'_>) -> Call {
        let (logits, level1) = ([self.logits[0], self.logits[1]], &self.levels[0]);
        let call = pyramid_finest(self.context, noisy, logits, level1);
        let [finest, own] = logits.map(confidences);
        let call = Call::per_tile("pyramid1", call);
        let call = call.moving(self.context, &[&finest, &own], &[level1]);
        call.touching(self.size(), &[noisy.color])
    }

    /// The calls from the noisy color to level 1, storing level 0.
    fn stored_beginning(&self, noisy: &NoisyColor<'_>, level0: &GpuTensor) -> Vec<Call> {
        let call = pyramid_level0(self.context, noisy, self.logits[0], level0);
        vec![self.first(call, level0, &[noisy.color]), self.level(1, level0)]
    }

    /// The calls from a layer, in place of the noisy color, to level 1.
    fn layer_beginning(
        &self,
        noisy: &NoisyColor<'_>,
        beauty: ImageBinding<'_>,
        level0: &GpuTensor,
    ) -> Vec<Call> {
        let call = pyramid_layer0(self.context, noisy, beauty, self.logits[0], level0);
        vec![self.first(call, level0, &[noisy.color, beauty]), self.level(1, level0)]
    }

    fn first(&self, dispatch: Dispatch, level0: &GpuTensor, images: &[ImageBinding<'_>]) -> Call {
        let confidences = confidences(self.logits[0]);
        let call = Call::per_tile("pyramid0", dispatch);
        let call = call.moving(self.context, &[&confidences], &[level0]);
        call.touching(self.size(), images)
    }

    /// The calls from level 1 to the coarsest, and back to the result of level 1.
    fn levels_and_results(&self) -> Vec<Call> {
        let count = self.logits.len();
        let down = (2..count).map(|l| self.level(l, &self.levels[l - 2]));
        down.chain((1..count).rev().map(|l| self.result(l))).collect()
    }

    /// The call that computes level `l` from the finer one.
    fn level(&self, l: usize, finer: &GpuTensor) -> Call {
        let (logits, level) = (self.logits[l], &self.levels[l - 1]);
        let call = pyramid(self.context, finer, logits, level);
        let call = Call::fixed(&format!("pyramid{l}"), call);
        call.moving(self.context, &[&confidences(logits)], &[finer, level])
    }

    /// The call that computes the result of level `l`, from the coarser one if there is one.
    fn result(&self, l: usize) -> Call {
        let (level, result, coarser) =
            (&self.levels[l - 1], &self.results[l - 1], self.results.get(l));
        let call = gather(self.context, [level, self.logits[l]], coarser, result);
        let light: Vec<_> = [level, result].into_iter().chain(coarser).collect();
        let call = Call::fixed(&format!("gather{l}"), call);
        call.moving(self.context, &[self.logits[l]], &light)
    }
}

/// How the pyramid reads the noisy color.
pub(super) fn noisy<'a>(images: &ResultImages<'a>) -> NoisyColor<'a> {
    let ResultImages { tiles, color, input_scale, encoding, .. } = *images;
    NoisyColor { tiles, color, input_scale, encoding }
}

/// The tensors that the last call reads, for counting bytes.
fn read<'a>(logits: &'a GpuTensor, contrast: Option<&'a Contrast>) -> Vec<&'a GpuTensor> {
    [logits].into_iter().chain(contrast.map(|contrast| &contrast.tensor)).collect()
}

/// The quad of logits that holds the confidence, the only one the pyramid reads, for counting
/// bytes.
fn confidences(logits: &GpuTensor) -> GpuTensor {
    GpuTensor { quads: 1, ..logits.clone() }
}
