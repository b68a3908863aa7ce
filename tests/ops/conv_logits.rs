use proptest::prelude::*;
use proptest::sample;
use wgdenoise::internals::model::{Network, Params};
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::conv_logits::conv_logits;
use wgdenoise::internals::ops::conv3x3::conv3x3;
use wgdenoise::internals::ops::need::Need;
use wgdenoise::internals::plan::halo;
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{KernelSet, Precision};

use wgdenoise_testing::gpu::{
    context, convolution_tolerance, factors, fused_sets, stored, sum_tolerance, variants_of,
};
use wgdenoise_testing::run::{activity_map, run, run_where};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// Channels, logits, height, width.
type Case = (usize, usize, usize, usize);

/// Channels at, below and above multiples of 4, up to 16. Sizes around the tile's 16, and the 32 of
/// a row of eight lanes with four pixels each.
const CASES: [Case; 6] = [
    (1, 1, 1, 1),
    (8, 11, 17, 33),
    (16, 11, 16, 32),
    (13, 10, 31, 5),
    (4, 4, 3, 70),
    (6, 12, 40, 17),
];

#[test]
fn conv_logits_equals_the_two_plain_operators_in_every_variant() {
    let variants = variants_of(fused_sets);
    let cases = CASES.iter().flat_map(|case| variants.iter().map(|variant| (*case, *variant)));
    run_cases(cases, |&(case, variant)| Problem::new(case, variant.1).check(variant));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn conv_logits_equals_the_two_plain_operators_at_any_shape(
        (channels, logits) in (1_usize..=16, 1_usize..20),
        (height, width) in (1_usize..40, 1_usize..70),
        variant in sample::select(variants_of(fused_sets)),
    ) {
        let problem = Problem::new((channels, logits, height, width), variant.1);
        problem.check(variant).map_err(TestCaseError::fail)?;
    }
}

#[test]
fn a_kernel_with_a_wrong_weight_fails_the_comparison() {
    for variant in variants_of(fused_sets) {
        let wrong: [fn(&mut Params) -> &mut f32; 4] = [
            |params| &mut params.weight[100],
            |params| &mut params.weight[9 * 64 + 87],
            |params| &mut params.bias[7],
            |params| &mut params.bias[18],
        ];
        for of in wrong {
            let mut problem = Problem::new(CASES[1], variant.1);
            let expected = problem.expected(variant.0);
            *of(&mut problem.params) += 0.5;
            compare(&problem.run(variant), &expected, problem.tolerance(variant)).unwrap_err();
        }
    }
}

/// The first channel reaches 9·10⁵, which 16 bits would store as 65504; the second overflows 32
/// bits, and times 0 must still be 0.
#[test]
fn what_stays_in_registers_has_the_range_of_32_bits() {
    for variant in variants_of(fused_sets) {
        let mut problem = Problem::new((2, 1, 3, 3), variant.1);
        problem.input.data.fill(1e4);
        let taps = |own: f32, other: f32| [[own; 9], [other; 9]].concat();
        problem.params.weight = [taps(5.0, 5.0), taps(0.0, 0.0), vec![1e-5, 0.0]].concat();
        problem.params.bias = vec![0.0; 3];
        let expected = problem.expected(variant.0);
        problem.params.weight[18..36].fill(3e38);
        compare(&problem.run(variant), &expected, problem.tolerance(variant)).unwrap();
    }
}

/// Only the middle of five blocks is needed. If a layer computes one block less around it than
/// [`halo::reach`] requires, it leaves pixels unwritten that the 3×3 convolution reads.
#[test]
fn the_tensor_that_it_reads_is_needed_as_far_as_the_plan_says() {
    let network = Network::unet(3, &[4]);
    let reach = halo::reach(&network)[1];
    for kernels in fused_sets(Precision::F32) {
        let mut problem = Problem::new((4, 3, 16, 80), Precision::F32);
        // Multiples of ¼ and ⅛, so that the intermediate tensor is exact in 16-bit factors: 36
        // products and a bias give multiples of 1/32 below 64.
        let in_steps = |values: &[f32], step: f32| -> Vec<f32> {
            values.iter().map(|v| (v / step).round() * step).collect()
        };
        let mut random = Random::new(9);
        let [weight, bias] = [4 * 4 * 9, 4].map(|n| in_steps(&random.values(n), 0.25));
        let first = Params { weight, bias };
        problem.input.data = in_steps(&problem.input.data, 0.125);
        let (context, map) = (context(Precision::F32), channel_map(4));
        let activity = activity_map(context, [5, 1], &[2, 1, 0, 1, 2]);
        let operator = conv3x3(context, kernels, &first, &map, true, false);
        let image = problem.input.clone();
        problem.input = reference::conv3x3(&image, &first.weight, &first.bias, true);
        let expected = middle(&problem.expected(kernels));
        let check = |reach| {
            let need = |reach| Need { map: &activity, level: 0, reach };
            let input = run_where(context, &operator, &[(&image, &map)], [4, 16, 80], need(reach));
            let logits = conv_logits(context, kernels, &problem.params, &map);
            let found = run_where(context, &logits, &[(&input, &map)], [3, 16, 80], need(0));
            let tolerance = convolution_tolerance(200, (kernels, Precision::F32));
            let unwritten = found.at(0, 0, 0) == -77.0 && found.at(2, 15, 79) == -77.0;
            assert!(unwritten, "{kernels} computed what nobody needs");
            compare(&middle(&found), &expected, tolerance)
        };
        check(reach).unwrap();
        check(reach - 1).unwrap_err();
    }
}

/// The middle of five blocks.
fn middle(tensor: &Tensor) -> Tensor {
    Tensor::from_fn(tensor.channels, 16, 16, |c, y, x| tensor.at(c, y, x + 32))
}

struct Problem {
    input: Tensor,
    params: Params,
    logits: usize,
}

impl Problem {
    fn new((channels, logits, height, width): Case, precision: Precision) -> Self {
        let mut random = Random::new((channels * 100 + logits) as u64);
        let input = stored(&random.tensor(channels, height, width), precision);
        let weight = random.values(9 * channels * channels + logits * channels);
        let params = Params { weight, bias: random.values(channels + logits) };
        Self { input, params, logits }
    }

    /// The reference, using the values that the kernels multiply. The 1×1 convolution rounds none.
    fn expected(&self, kernels: KernelSet) -> Tensor {
        let channels = self.input.channels;
        let (conv, logits) = self.params.weight.split_at(9 * channels * channels);
        let weight = [factors(kernels, conv), logits.to_vec()].concat();
        let input = Tensor { data: factors(kernels, &self.input.data), ..self.input };
        reference::conv_logits(&input, &Params { weight, bias: self.params.bias.clone() })
    }

    fn run(&self, (kernels, precision): (KernelSet, Precision)) -> Tensor {
        let Self { input, params, logits } = self;
        let (context, map) = (context(precision), channel_map(input.channels));
        let operator = conv_logits(context, kernels, params, &map);
        run(context, &operator, input, &map, [*logits, input.height, input.width])
    }

    /// A channel between the convolutions is off by the rounding of its sum, and as large as a sum
    /// of that many products. The errors of `c` channels add up like `√c`, and the 1×1 convolution
    /// rounds a sum of `c` such channels.
    fn tolerance(&self, (kernels, precision): (KernelSet, Precision)) -> Tolerance {
        let channels = self.input.channels;
        let channel = convolution_tolerance(9 * channels, (kernels, Precision::F32)).absolute;
        let sum = sum_tolerance(channels, Precision::F32).absolute;
        let [root, terms] = [channels, 9 * channels].map(|count| (count as f32).sqrt());
        let absolute = root * channel + terms * sum;
        Tolerance { absolute, ..sum_tolerance(1, precision) }
    }

    fn check(&self, variant: (KernelSet, Precision)) -> Result<(), String> {
        compare(&self.run(variant), &self.expected(variant.0), self.tolerance(variant))
    }
}
