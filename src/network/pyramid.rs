//! The end of a network that predicts a kernel pyramid: the calls from its logits to the image, and
//! to further layers of the picture.

use super::call::Call;
use crate::gpu::kernel::{Context, Dispatch};
use crate::gpu::tensor::GpuTensor;
use crate::ops::activity::Activity;
use crate::ops::gather::{gather, gather_finest, gather_layer};
use crate::ops::image::ImageBinding;
use crate::ops::output_process::ResultImages;
use crate::ops::pyramid::{NoisyColor, pyramid, pyramid_finest, pyramid_layer0, pyramid_level0};

/// Bytes of a pixel: a color and its weight as 32-bit floats.
const PIXEL_BYTES: u64 = 16;

/// GPU memory in bytes for the pyramid of a tile and its results, of which level 0 is the image.
pub(crate) fn bytes(tile: [u32; 2], levels: usize, stores_level0: bool) -> u64 {
    let level = |l| tile.map(|side| u64::from(side >> l)).iter().product::<u64>();
    let level0 = if stores_level0 { level(0) } else { 0 };
    PIXEL_BYTES * (level0 + 2 * (1..levels).map(level).sum::<u64>())
}

/// The end of a network on one tile: what it predicted, and room for the pyramid and its results.
pub(super) struct Pyramid<'a> {
    context: &'a Context,
    /// By level.
    logits: Vec<&'a GpuTensor>,
    activity: &'a Activity,
    level0: Option<GpuTensor>,
    /// From level 1 on.
    levels: Vec<GpuTensor>,
    results: Vec<GpuTensor>,
}

impl<'a> Pyramid<'a> {
    /// Creates the textures. `stores_level0` is needed for layers.
    pub(super) fn new(
        context: &'a Context,
        logits: Vec<&'a GpuTensor>,
        activity: &'a Activity,
        stores_level0: bool,
    ) -> Self {
        let light = |l: usize| GpuTensor::light(context, [logits[l].width, logits[l].height]);
        let level0 = stores_level0.then(|| light(0));
        let levels = (1..logits.len()).map(light).collect();
        let results = (1..logits.len()).map(light).collect();
        Self { context, logits, activity, level0, levels, results }
    }

    /// The calls that store the image. With `reads_level0`, they store level 0 of the pyramid and
    /// read it; otherwise they compute it where they need it.
    pub(super) fn image(&self, images: &ResultImages<'_>, reads_level0: bool) -> Vec<Call> {
        let level0 = self.level0.as_ref().filter(|_| reads_level0);
        let mut calls = match level0 {
            Some(level0) => self.stored_beginning(images, level0),
            None => vec![self.computed_beginning(images)],
        };
        calls.extend(self.levels_and_results());
        let last = gather_finest(self.context, self.last_inputs(), level0, self.activity, images);
        calls.push(self.last(last, level0, images));
        calls
    }

    /// The calls that store a further layer, the color of `images`, by the same weights. `beauty` is
    /// the color that the network reads.
    ///
    /// # Panics
    /// Panics if there is no texture for level 0.
    pub(super) fn layer(&self, images: &ResultImages<'_>, beauty: ImageBinding<'_>) -> Vec<Call> {
        let level0 = self.level0.as_ref().expect("there is one where there are layers");
        let mut calls = self.layer_beginning(images, beauty, level0);
        calls.extend(self.levels_and_results());
        let last = gather_layer(self.context, self.last_inputs(), level0, self.activity, images);
        calls.push(self.last(last, Some(level0), images));
        calls
    }

    fn last_inputs(&self) -> [&GpuTensor; 2] {
        [self.logits[0], &self.results[0]]
    }

    /// It reads the noisy color where level 0 is not stored.
    fn last(
        &self,
        dispatch: Dispatch,
        level0: Option<&GpuTensor>,
        images: &ResultImages<'_>,
    ) -> Call {
        let light: Vec<_> = [&self.results[0]].into_iter().chain(level0).collect();
        let call = Call::per_tile("gather0", dispatch);
        let call = call.moving(self.context, &self.logits[..1], &light);
        let color = level0.is_none().then_some(images.color);
        let touched: Vec<_> = [images.output].into_iter().chain(color).collect();
        call.touching(self.size(), &touched)
    }

    /// Of full resolution.
    fn size(&self) -> [u32; 2] {
        [self.logits[0].width, self.logits[0].height]
    }

    /// From the noisy color to level 1 without storing level 0.
    fn computed_beginning(&self, images: &ResultImages<'_>) -> Call {
        let (logits, level1) = ([self.logits[0], self.logits[1]], &self.levels[0]);
        let call = pyramid_finest(self.context, &noisy(images), logits, level1);
        let read = logits.map(confidences);
        let call = Call::per_tile("pyramid1", call);
        let call = call.moving(self.context, &[&read[0], &read[1]], &[level1]);
        call.touching(self.size(), &[images.color])
    }

    /// From the noisy color to level 1.
    fn stored_beginning(&self, images: &ResultImages<'_>, level0: &GpuTensor) -> Vec<Call> {
        let call = pyramid_level0(self.context, &noisy(images), self.logits[0], level0);
        vec![self.first(call, level0, &[images.color]), self.level(1, level0)]
    }

    /// From the layer that is the color of `images` to level 1.
    fn layer_beginning(
        &self,
        images: &ResultImages<'_>,
        beauty: ImageBinding<'_>,
        level0: &GpuTensor,
    ) -> Vec<Call> {
        let logits = self.logits[0];
        let call = pyramid_layer0(self.context, &noisy(images), beauty, logits, level0);
        vec![self.first(call, level0, &[images.color, beauty]), self.level(1, level0)]
    }

    fn first(&self, dispatch: Dispatch, level0: &GpuTensor, read: &[ImageBinding<'_>]) -> Call {
        let confidences = confidences(self.logits[0]);
        let call = Call::per_tile("pyramid0", dispatch);
        call.moving(self.context, &[&confidences], &[level0]).touching(self.size(), read)
    }

    /// From level 1 to the coarsest, and back to the result of level 1.
    fn levels_and_results(&self) -> Vec<Call> {
        let count = self.logits.len();
        let down = (2..count).map(|l| self.level(l, &self.levels[l - 2]));
        down.chain((1..count).rev().map(|l| self.result(l))).collect()
    }

    /// Level `l` from the finer one.
    fn level(&self, l: usize, finer: &GpuTensor) -> Call {
        let (logits, level) = (self.logits[l], &self.levels[l - 1]);
        let call = pyramid(self.context, finer, logits, level);
        let call = Call::fixed(&format!("pyramid{l}"), call);
        call.moving(self.context, &[&confidences(logits)], &[finer, level])
    }

    /// The result of level `l` from the coarser one.
    fn result(&self, l: usize) -> Call {
        let (level, result, coarser) =
            (&self.levels[l - 1], &self.results[l - 1], self.results.get(l));
        let call = gather(self.context, [level, self.logits[l]], coarser, result);
        let light: Vec<_> = [level, result].into_iter().chain(coarser).collect();
        let call = Call::fixed(&format!("gather{l}"), call);
        call.moving(self.context, &[self.logits[l]], &light)
    }
}

fn noisy<'a>(images: &ResultImages<'a>) -> NoisyColor<'a> {
    let ResultImages { tiles, color, input_scale, encoding, .. } = *images;
    NoisyColor { tiles, color, input_scale, encoding }
}

/// The quad of logits that has the confidence, all that the pyramid reads of them. For counting.
fn confidences(logits: &GpuTensor) -> GpuTensor {
    GpuTensor { quads: 1, ..logits.clone() }
}
