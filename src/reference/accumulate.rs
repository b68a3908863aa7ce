//! Averages a denoised frame with the last ones along motion vectors.

use super::repair::GREY;
use crate::image::Image;

/// Differences at which agreement falls to 1/e: albedo, normals, and light and depth relative to
/// their mean.
const ALBEDO: f64 = 0.1;
const NORMAL: f64 = 0.2;
const LIGHT: f64 = 0.3;
const DEPTH: f64 = 0.1;
/// Values that leave the range of the nearest pixels by no more than this, relative to them, do so
/// by rounding alone.
const ROUNDING: f64 = 3e-6;
/// Exposed light that counts as dark: half a percent of the average.
const DARK: f64 = 0.005 * GREY;

/// A denoised frame and the features of its surfaces, row by row. All images have one size.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Linear light, finite.
    pub denoised: &'a Image,
    /// Further denoised layers of the image, finite.
    pub layers: &'a [&'a Image],
    /// Where each pixel's surface was in the last frame, relative to the pixel: x right, y down.
    pub motion: &'a [[f32; 2]],
    /// Albedo in `[0, 1]`.
    pub albedo: Option<&'a Image>,
    /// Normals in `[−1, 1]`, 0 where nothing was hit.
    pub normal: Option<&'a Image>,
    /// Distances from the camera's plane; 0, infinite or NaN where nothing was hit.
    pub depth: Option<&'a [f32]>,
    /// The factor that brings light to the network's exposure.
    pub input_scale: f32,
}

/// The history that a frame leaves for the next one, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct History(pub Vec<Past>);

/// A pixel of the history.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// The mean of the frames: the result.
    pub color: [f64; 3],
    /// The same mean for each layer.
    pub layers: Vec<[f64; 3]>,
    /// The number of frames that the mean counts: at least 1.
    pub count: f64,
    seen: Seen,
}

/// Means of 3×3 pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Seen {
    light: [f64; 3],
    albedo: [f64; 3],
    normal: [f64; 3],
    depth: f64,
}

/// Averages a frame, with weight 1, and the history at `q`, the end of each pixel's motion, with
/// weight `n = v · min(count, longest)`:
///
/// `v = exp(−(Δalbedo / 0.1)² − (Δnormal / 0.2)² − (Δlight / 0.3)² − (Δdepth / 0.1)²)`
///
/// Δalbedo and Δnormal are mean differences of channels; Δlight and Δdepth are relative to the mean
/// of both sides. All compare means of 3×3 pixels, those of the history read bilinearly at `q`.
/// Light is exposed, and half a percent of middle gray is added to its mean. Depths are averaged
/// where something was hit. Albedo and normals are rounded to steps of 1/255 and 1/127, as the
/// history keeps them.
///
/// The color at `q` is read with Catmull-Rom splines, as far as these stay in the range of the four
/// nearest pixels, and bilinearly beyond that. Layers are averaged with the same weights and read
/// in the same way: all images use the largest share of the splines that every one of them allows.
/// The history does not count where `q` is not a number or lies outside the image, whose border is
/// half a pixel beyond the outermost centers. Beyond the edge of the image, its pixels repeat.
///
/// # Panics
/// Panics if the sizes differ.
#[must_use]
pub fn accumulate(frame: &Frame<'_>, history: Option<&History>, longest: f64) -> History {
    let (width, height) = frame.denoised.size();
    let grid = Grid { width: i64::from(width), height: i64::from(height) };
    let pixel = |i: usize| {
        let own = seen(frame, grid, i);
        let light = |image: &Image| image.pixels()[i].map(f64::from);
        let color = light(frame.denoised);
        let layers: Vec<_> = frame.layers.iter().map(|layer| light(layer)).collect();
        let place = grid.end(i, frame.motion[i]);
        let Some((place, history)) = place.zip(history) else {
            return Past { color, layers, count: 1.0, seen: own };
        };
        let taps = Taps::new(grid, place, &history.0);
        let v = agreement(&own, &taps.seen(f64::from(frame.input_scale)));
        let frames = v * taps.linear(|past| past.count).min(longest);
        let mean = |own: [f64; 3], past: [f64; 3]| {
            [0, 1, 2].map(|c| (own[c] + frames * past[c]) / (1.0 + frames))
        };
        let past = taps.lights(layers.len());
        let means = layers.iter().zip(&past[1..]).map(|(own, past)| mean(*own, *past));
        let (color, layers) = (mean(color, past[0]), means.collect());
        Past { color, layers, count: 1.0 + frames, seen: own }
    };
    History((0..frame.motion.len()).map(pixel).collect())
}

fn agreement(own: &Seen, other: &Seen) -> f64 {
    let all = own.light.iter().chain(&other.light);
    let mean = all.map(|v| v.max(0.0)).sum::<f64>() / 6.0;
    let light = difference(own.light, other.light) / (mean + DARK);
    let depths = own.depth + other.depth;
    let depth = if depths > 0.0 { 2.0 * (own.depth - other.depth) / depths } else { 0.0 };
    let albedo = difference(own.albedo, other.albedo);
    let normal = difference(own.normal, other.normal);
    let scaled = [light / LIGHT, albedo / ALBEDO, normal / NORMAL, depth / DEPTH];
    (-scaled.iter().map(|v| v * v).sum::<f64>()).exp()
}

/// The mean difference of the channels.
fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f64>() / 3.0
}

fn seen(frame: &Frame<'_>, grid: Grid, i: usize) -> Seen {
    let [x, y] = grid.place(i);
    let nine: Vec<_> = (0..9).map(|k| grid.index(x + k % 3 - 1, y + k / 3 - 1)).collect();
    let mean = |image: &Image| {
        let channel = |c: usize| nine.iter().map(|&k| f64::from(image.pixels()[k][c])).sum::<f64>();
        [0, 1, 2].map(|c| channel(c) / 9.0)
    };
    let depths = frame.depth.iter().flat_map(|depth| nine.iter().map(|&k| f64::from(depth[k])));
    let hits: Vec<_> = depths.filter(|depth| depth.is_finite() && *depth > 0.0).collect();
    let rounded = |v: f64, steps: f64| (v * steps).round() / steps;
    Seen {
        light: mean(frame.denoised).map(|v| v * f64::from(frame.input_scale)),
        albedo: frame.albedo.map_or([0.0; 3], mean).map(|v| rounded(v, 255.0)),
        normal: frame.normal.map_or([0.0; 3], mean).map(|v| rounded(v, 127.0)),
        depth: hits.iter().sum::<f64>() / hits.len().max(1) as f64,
    }
}

/// The pixels of an image.
#[derive(Clone, Copy)]
struct Grid {
    width: i64,
    height: i64,
}

impl Grid {
    fn place(self, i: usize) -> [i64; 2] {
        [i as i64 % self.width, i as i64 / self.width]
    }

    /// The index of a pixel. Beyond the edges, pixels repeat.
    fn index(self, x: i64, y: i64) -> usize {
        (y.clamp(0, self.height - 1) * self.width + x.clamp(0, self.width - 1)) as usize
    }

    /// Where the motion of a pixel ends, if that is in the image.
    fn end(self, i: usize, motion: [f32; 2]) -> Option<[f64; 2]> {
        let [x, y] = self.place(i);
        let [x, y] = [x as f64 + f64::from(motion[0]), y as f64 + f64::from(motion[1])];
        let is_inside = |v: f64, side: i64| (-0.5..=side as f64 - 0.5).contains(&v);
        (is_inside(x, self.width) && is_inside(y, self.height)).then_some([x, y])
    }
}

/// A value of an image between its pixels.
struct Reading {
    /// The bilinear mean.
    linear: [f64; 3],
    /// What splines add to it.
    change: [f64; 3],
    /// The largest share of `change` that keeps the value in the range of the four nearest pixels.
    share: f64,
}

/// The 4×4 pixels of the history around a place.
struct Taps<'a> {
    pixels: [&'a Past; 16],
    /// The position between the four nearest pixels.
    t: [f64; 2],
}

impl<'a> Taps<'a> {
    fn new(grid: Grid, place: [f64; 2], history: &'a [Past]) -> Self {
        let [x, y] = place.map(|v| v.floor() as i64 - 1);
        let pixel = |k: usize| &history[grid.index(x + k as i64 % 4, y + k as i64 / 4)];
        Self { pixels: std::array::from_fn(pixel), t: place.map(|v| v - v.floor()) }
    }

    /// The sum with weights along each axis.
    fn sum(&self, weights: fn(f64) -> [f64; 4], value: impl Fn(&Past) -> f64) -> f64 {
        let [across, down] = self.t.map(weights);
        (0..16).map(|k| across[k % 4] * down[k / 4] * value(self.pixels[k])).sum()
    }

    fn linear(&self, value: impl Fn(&Past) -> f64) -> f64 {
        self.sum(|t| [0.0, 1.0 - t, t, 0.0], value)
    }

    /// The color, then each layer.
    fn lights(&self, layers: usize) -> Vec<[f64; 3]> {
        let color = self.reading(|past| past.color);
        let layers = (0..layers).map(|l| self.reading(move |past| past.layers[l]));
        let all: Vec<_> = [color].into_iter().chain(layers).collect();
        let share = all.iter().map(|reading| reading.share).fold(1.0, f64::min);
        let light = |of: &Reading| [0, 1, 2].map(|c| of.linear[c] + share * of.change[c]);
        all.iter().map(light).collect()
    }

    fn reading(&self, light: impl Fn(&Past) -> [f64; 3]) -> Reading {
        let spline = |t: f64| {
            let cube = [-t + 2.0 * t * t - t.powi(3), 2.0 - 5.0 * t * t + 3.0 * t.powi(3)];
            let rest = [t + 4.0 * t * t - 3.0 * t.powi(3), t.powi(3) - t * t];
            [cube[0] / 2.0, cube[1] / 2.0, rest[0] / 2.0, rest[1] / 2.0]
        };
        let linear = [0, 1, 2].map(|c| self.linear(|past| light(past)[c]));
        let change: [f64; 3] =
            [0, 1, 2].map(|c| self.sum(spline, |past| light(past)[c]) - linear[c]);
        let share = |c: usize| {
            let four = [5, 6, 9, 10].map(|k| light(self.pixels[k])[c]);
            let bound = four.into_iter().reduce(if change[c] > 0.0 { f64::max } else { f64::min });
            let room = (bound.expect("there are four") - linear[c]).abs();
            let rounding = ROUNDING * four.into_iter().map(f64::abs).fold(0.0, f64::max);
            if change[c].abs() > room + rounding { room / change[c].abs() } else { 1.0 }
        };
        Reading { linear, change, share: (0..3).map(share).fold(1.0, f64::min) }
    }

    fn seen(&self, input_scale: f64) -> Seen {
        let wide = |t: f64| [(1.0 - t) / 3.0, 1.0 / 3.0, 1.0 / 3.0, t / 3.0];
        let hit = |past: &Past| f64::from(u8::from(past.seen.depth > 0.0));
        let hits = self.linear(hit);
        let depth = self.linear(|past| past.seen.depth);
        Seen {
            light: [0, 1, 2].map(|c| input_scale * self.sum(wide, |past| past.color[c])),
            albedo: [0, 1, 2].map(|c| self.linear(|past| past.seen.albedo[c])),
            normal: [0, 1, 2].map(|c| self.linear(|past| past.seen.normal[c])),
            depth: if hits > 0.0 { depth / hits } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (6, 4);

    fn gray(value: f32) -> Image {
        Image::filled(SIZE.0, SIZE.1, [value; 3]).expect("a valid image")
    }

    fn frame<'a>(denoised: &'a Image, motion: &'a [[f32; 2]]) -> Frame<'a> {
        let (albedo, normal, depth) = (None, None, None);
        Frame { denoised, layers: &[], motion, albedo, normal, depth, input_scale: 1.0 }
    }

    const STILL: [[f32; 2]; 24] = [[0.0; 2]; 24];

    #[test]
    fn equal_frames_count_one_each_up_to_the_longest_history() {
        let image = gray(0.5);
        let mut history = accumulate(&frame(&image, &STILL), None, 2.5);
        for expected in [2.0, 3.0, 3.5, 3.5] {
            history = accumulate(&frame(&image, &STILL), Some(&history), 2.5);
            let found = history.0.iter().map(|past| (past.color, past.count));
            assert!(found.into_iter().all(|past| past == ([0.5; 3], expected)), "{history:?}");
        }
    }

    #[test]
    fn each_difference_has_its_scale() {
        let (one, other) = (gray(0.5), gray(0.6));
        let [near, far] = [[1.0_f32; 24], [1.1; 24]];
        let own = Frame {
            albedo: Some(&one),
            normal: Some(&one),
            depth: Some(&near),
            ..frame(&one, &STILL)
        };
        let last = accumulate(&own, None, 8.0);
        let agreement = |frame| accumulate(&frame, Some(&last), 8.0).0[7].count - 1.0;
        let expected = |scaled: f64| (-scaled * scaled).exp();
        let steps = |v: f64, n: f64| (v * n).round() / n;
        let albedo = expected((steps(0.6, 255.0) - steps(0.5, 255.0)) / 0.1);
        let normal = expected((steps(0.6, 127.0) - steps(0.5, 127.0)) / 0.2);
        for (what, frame, expected) in [
            ("light", Frame { denoised: &other, ..own }, expected(0.1 / 0.5509 / 0.3)),
            ("albedo", Frame { albedo: Some(&other), ..own }, albedo),
            ("normal", Frame { normal: Some(&other), ..own }, normal),
            ("depth", Frame { depth: Some(&far), ..own }, expected(0.1 / 1.05 / 0.1)),
        ] {
            let found = agreement(frame);
            assert!((found - expected).abs() < 1e-6, "{what}: {found}, expected {expected}");
        }
    }

    #[test]
    fn what_moves_is_fetched_from_where_it_was() {
        let ramp = |from: f32| {
            let pixels = (0..24_u8).map(|i| [from + 0.01 * f32::from(i % 6); 3]).collect();
            Image::new(SIZE.0, SIZE.1, pixels).expect("a valid image")
        };
        let history = accumulate(&frame(&ramp(1.0), &STILL), None, 8.0);
        for (right, inside) in [(1.0_f32, 5), (1.5, 5), (-2.0, 4), (6.0, 0), (f32::NAN, 0)] {
            let moved = ramp(1.0 + 0.01 * right);
            let moved = if right.is_nan() { ramp(1.0) } else { moved };
            let found = accumulate(&frame(&moved, &[[right, 0.0]; 24]), Some(&history), 8.0);
            let counts = found.0[6..12].iter().filter(|past| past.count > 1.0);
            assert_eq!(counts.count(), inside, "{right}");
            // At the edges, where pixels repeat, the ramp ends.
            let [found, expected] = [found.0[8].color[0], f64::from(moved.pixels()[8][0])];
            assert!((found - expected).abs() < 1e-7, "{right}: {found}, expected {expected}");
        }
    }

    #[test]
    fn depth_that_was_not_hit_agrees_with_none_only() {
        let image = gray(0.5);
        let [none, some] = [[f32::INFINITY; 24], [3.0; 24]];
        let with = |depth| Frame { depth: Some(depth), ..frame(&image, &STILL) };
        let last = accumulate(&with(&none), None, 8.0);
        let counts = [&none, &some].map(|d| accumulate(&with(d), Some(&last), 8.0).0[0].count);
        assert_eq!(counts, [2.0, 1.0]);
    }

    /// Uses a peak, and an edge next to which splines overshoot unless they are left out.
    #[test]
    fn layers_are_as_soft_as_the_softest_image() {
        let row = |values: [f32; 6]| {
            let pixels = (0..24).map(|i| [values[i % 6]; 3]).collect();
            Image::new(SIZE.0, SIZE.1, pixels).expect("a valid image")
        };
        let (peak, edge) =
            (row([0.5, 0.5, 1.0, 0.5, 0.5, 0.5]), row([0.0, 0.0, 1.0, 1.0, 1.0, 1.0]));
        let motion = [[0.25, 0.0]; 24];
        let mean = |layers: &[&Image]| {
            let frame = |motion| Frame { layers, ..frame(&peak, motion) };
            let first = accumulate(&frame(&STILL), None, 8.0);
            let Past { color, layers, count, .. } =
                accumulate(&frame(&motion), Some(&first), 8.0).0.swap_remove(8);
            let past = |mean: f64, own: f64| (mean * count - own) / (count - 1.0);
            (past(color[0], 1.0), layers.iter().map(|mean| past(mean[0], 1.0)).collect::<Vec<_>>())
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a}, expected {b}");
        // The spline's weight of the peak: 1 + t² (1.5 t − 2.5) with t = 0.25.
        let (color, layers) = mean(&[&peak]);
        close(color, 0.5 + 0.5 * 0.8671875);
        close(layers[0], color);
        let (color, layers) = mean(&[&peak, &edge]);
        close(color, 0.5 + 0.5 * 0.75);
        close(layers[0], color);
        close(layers[1], 1.0);
    }
}
