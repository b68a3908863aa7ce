use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::model::{Network, Params};
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::conv_head::conv_head;
use wgdenoise::internals::ops::need::Need;
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::ops::{conv3x3::conv3x3, head::Head};
use wgdenoise::internals::plan::halo;
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Image, KernelSet, Precision};

use super::head::store;
use wgdenoise_testing::gpu::{context, kernel_sets, stored, sum_tolerance, variants_of};
use wgdenoise_testing::run::{activity_map, run, run_where};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Channels in and out, size of the images, the tile's first pixel in them. The tile has whole
/// blocks and covers the rest of the images; a border of one pixel is not stored.
type Case = (usize, usize, [u32; 2], [u32; 2]);

/// Channels at, below and above multiples of 4, up to 16 out; sizes around the 16 of a block and
/// the 32 of a row of eight lanes with four pixels each; tiles at even and odd pixels.
const CASES: [Case; 7] = [
    (1, 1, [3, 3], [0, 0]),
    (8, 8, [33, 17], [0, 0]),
    (16, 16, [70, 40], [3, 5]),
    (16, 12, [49, 51], [17, 2]),
    (5, 3, [40, 33], [7, 16]),
    (20, 13, [80, 20], [15, 1]),
    (3, 5, [18, 35], [1, 0]),
];

/// The sets that have the operator.
fn sets(precision: Precision) -> Vec<KernelSet> {
    let has = |set: &KernelSet| matches!(set, KernelSet::Simd | KernelSet::Tiled);
    kernel_sets(precision).into_iter().filter(has).collect()
}

#[test]
fn conv_head_equals_the_reference_and_stores_what_it_should() {
    let variants = variants_of(sets);
    let cases = CASES.iter().flat_map(|case| variants.iter().map(|variant| (*case, *variant)));
    run_cases(cases, |&(case, variant)| check(&Problem::new(case, variant.1), variant));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn conv_head_equals_the_reference_at_any_shape(
        (inputs, outputs) in (1_usize..30, 1_usize..=16),
        (size, origin) in ([19_u32..60, 19_u32..60], [0_u32..17, 0_u32..17]),
        variant in sample::select(variants_of(sets)),
    ) {
        let problem = Problem::new((inputs, outputs, size, origin), variant.1);
        check(&problem, variant).map_err(TestCaseError::fail)?;
    }
}

#[test]
fn conv_head_equals_the_two_kernels_that_it_replaces() {
    for kernels in sets(Precision::F32) {
        let problem = Problem::new((16, 12, [64, 48], [0, 0]), Precision::F32);
        let Problem { input, conv, params, tile, clean, color } = &problem;
        let (context, map) = (context(Precision::F32), channel_map(16));
        let between = conv3x3(context, kernels, conv, &map, true, false);
        let shape = [12, input.height, input.width];
        let between = run(context, &between, input, &map, shape);
        let head = Head::new(context, kernels, params, &channel_map(12));
        let expected = store(context, &head, &between, tile, clean, color, problem.count());
        let found = problem.run(kernels, Precision::F32);
        compare(&flat(&found), &flat(&expected), problem.tolerance()).unwrap();
    }
}

#[test]
fn a_kernel_with_a_wrong_weight_fails_the_comparison() {
    for variant in variants_of(sets) {
        let wrong: [fn(&mut Problem) -> &mut f32; 4] = [
            |problem| &mut problem.conv.weight[100],
            |problem| &mut problem.conv.bias[11],
            |problem| &mut problem.params.weight[15],
            |problem| &mut problem.params.bias[2],
        ];
        for of in wrong {
            let mut problem = Problem::new(CASES[3], variant.1);
            let expected = problem.expected();
            *of(&mut problem) += 0.1;
            let found = problem.run(variant.0, variant.1);
            compare(&flat(&found), &flat(&expected), problem.tolerance()).unwrap_err();
        }
    }
}

/// The first channel comes to 9·10⁵, which 16 bits would store as 65504; the second is beyond 32
/// bits, and must still be nothing times 0.
#[test]
fn what_stays_in_registers_has_the_range_of_32_bits() {
    for (kernels, precision) in variants_of(sets) {
        let mut problem = Problem::new((1, 2, [3, 3], [0, 0]), precision);
        problem.input.data.fill(1e4);
        problem.conv = Params { weight: [10.0, 0.0].map(|w| [w; 9]).concat(), bias: vec![0.0; 2] };
        problem.params = Params { weight: [1e-5, 0.0].repeat(3), bias: vec![0.0; 3] };
        let expected = problem.expected();
        problem.conv.weight[9..].fill(3e38);
        let found = problem.run(kernels, precision);
        compare(&flat(&found), &flat(&expected), problem.tolerance()).unwrap();
    }
}

/// Only the middle one of five blocks is needed. A layer that computes a block less around it
/// than [`halo::reach`] says leaves pixels that the 3×3 convolution reads.
#[test]
fn the_tensor_that_it_reads_is_needed_as_far_as_the_plan_says() {
    let network = Network::unet(3, &[4]);
    let reach = halo::reach(&network)[1];
    for kernels in sets(Precision::F32) {
        let mut problem = Problem::new((4, 4, [80, 16], [0, 0]), Precision::F32);
        problem.clean = vec![true, true, false, true, true];
        let first = problem.conv.clone();
        let (context, map) = (context(Precision::F32), channel_map(4));
        let activity = activity_map(context, [5, 1], &[2, 1, 0, 1, 2]);
        let operator = conv3x3(context, kernels, &first, &map, true, false);
        let image = problem.input.clone();
        problem.input = reference::conv3x3(&image, &first.weight, &first.bias, true);
        let expected = problem.expected();
        let mut check = |reach| {
            let need = Need { map: &activity, level: 0, reach };
            problem.input = run_where(context, &operator, &[(&image, &map)], [4, 16, 80], need);
            let found = problem.run(kernels, Precision::F32);
            compare(&flat(&found), &flat(&expected), problem.tolerance())
        };
        check(reach).unwrap();
        check(reach - 1).unwrap_err();
    }
}

struct Problem {
    input: Tensor,
    conv: Params,
    params: Params,
    tile: Tile,
    clean: Vec<bool>,
    color: Vec<f32>,
}

impl Problem {
    fn new((inputs, outputs, size, origin): Case, precision: Precision) -> Self {
        let mut random = Random::new((inputs * 100 + outputs) as u64);
        let sides = [0, 1].map(|axis| (size[axis] - origin[axis]).next_multiple_of(16));
        let input = random.tensor(inputs, sides[1] as usize, sides[0] as usize);
        let weight = random.values(outputs * inputs * 9);
        let conv = Params { weight, bias: random.values(outputs) };
        let params = Params { weight: random.values(3 * outputs), bias: random.values(3) };
        let color = Layout::new(3, size[0] * 4 + 1, 4);
        let tile = Tile {
            image_size: size,
            origin,
            begin: origin.map(|first| first + 1),
            end: size.map(|side| side - 1),
            color,
            output: Layout::new(5, size[0] * 3 + 2, 3),
            ..Tile::default()
        };
        let clean = (0..sides[0] / 16 * (sides[1] / 16)).map(|block| block % 3 == 1).collect();
        let color = random.values(color.elements(size[0], size[1]) as usize);
        Self { input: stored(&input, precision), conv, params, tile, clean, color }
    }

    /// Elements of the output.
    fn count(&self) -> usize {
        let [width, height] = self.tile.image_size;
        self.tile.output.elements(width, height) as usize
    }

    /// The pixels of the images, each with its block of the tile and whether it is stored.
    fn pixels(&self) -> impl Iterator<Item = ([u32; 2], bool)> {
        let Tile { image_size: [width, height], begin, end, .. } = self.tile;
        let inside = move |x, y| (begin[0]..end[0]).contains(&x) && (begin[1]..end[1]).contains(&y);
        (0..height).flat_map(move |y| (0..width).map(move |x| ([x, y], inside(x, y))))
    }

    fn expected(&self) -> Vec<f32> {
        let [first_x, first_y] = self.tile.origin;
        let [width, height] = self.tile.image_size;
        let color = |[x, y]: [u32; 2]| {
            let i = element(&self.tile.color, x, y);
            [self.color[i], self.color[i + 1], self.color[i + 2]]
        };
        let inside = self.pixels().filter(|([x, y], _)| *x >= first_x && *y >= first_y);
        let color = inside.map(|(pixel, _)| color(pixel)).collect();
        let color = Image::new(width - first_x, height - first_y, color).expect("a rectangle");
        let params = [&self.conv, &self.params];
        let image = reference::conv_head(&self.input, params, 2.5, &self.clean, &color);
        let mut expected = vec![-1.0; self.count()];
        for ([x, y], _) in self.pixels().filter(|(_, stored)| *stored) {
            let pixel = image.row(y - first_y)[(x - first_x) as usize];
            expected[element(&self.tile.output, x, y)..][..3].copy_from_slice(&pixel);
        }
        expected
    }

    fn run(&self, kernels: KernelSet, precision: Precision) -> Vec<f32> {
        let (context, params) = (context(precision), [&self.conv, &self.params]);
        let map = channel_map(self.input.channels);
        let head = conv_head(context, kernels, params, &map);
        store(context, &head, &self.input, &self.tile, &self.clean, &self.color, self.count())
    }

    /// A channel between the convolutions may be off by the rounding of its sum and is as large
    /// as a sum of that many products; the errors of `c` channels add up like `√c`, and the 1×1
    /// convolution rounds a sum of `c` such channels. The curve multiplies an error before the
    /// sigmoid by at most a quarter of 16.3, on top of what `output_process` may be off by.
    fn tolerance(&self) -> Tolerance {
        let (terms, channels) = (9 * self.input.channels, self.conv.bias.len());
        let sum = |terms| sum_tolerance(terms, Precision::F32).absolute;
        let error = (channels as f32).sqrt() * sum(terms) + (terms as f32).sqrt() * sum(channels);
        Tolerance { absolute: 1e-9, relative: 2e-5 + 16.3 / 4.0 * error }
    }
}

/// Compares everything that the kernel may write, and the clean blocks bit by bit.
fn check(problem: &Problem, (kernels, precision): (KernelSet, Precision)) -> Result<(), String> {
    let (found, expected) = (problem.run(kernels, precision), problem.expected());
    compare(&flat(&found), &flat(&expected), problem.tolerance())?;
    let tile = &problem.tile;
    for ([x, y], _) in problem.pixels().filter(|(_, stored)| *stored) {
        let blocks = problem.input.width / 16;
        let block =
            (y - tile.origin[1]) as usize / 16 * blocks + (x - tile.origin[0]) as usize / 16;
        let at = element(&tile.output, x, y);
        if problem.clean[block]
            && (0..3).any(|c| found[at + c].to_bits() != expected[at + c].to_bits())
        {
            return Err(format!("pixel {x}, {y} of a clean block is not its input"));
        }
    }
    Ok(())
}

fn element(layout: &Layout, x: u32, y: u32) -> usize {
    (layout.offset + y * layout.row_stride + x * layout.pixel_stride) as usize
}

fn flat(values: &[f32]) -> Tensor {
    Tensor::new(1, 1, values.len(), values.to_vec())
}
