//! The GPU kernels' first convolution, which reads the images.

use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::{Encoding, Params};
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::conv3x3::conv3x3;
use wgdenoise::internals::ops::input_conv::InputConv;
use wgdenoise::internals::ops::input_process::{self, Sources, input_process};
use wgdenoise::internals::ops::need::{Need, everything};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Image, Inputs, KernelSet, Precision};

use wgdenoise_testing::gpu::{
    buffer, context, convolution_tolerance, download, factors, kernel_sets, submit, upload,
    variants_of,
};
use wgdenoise_testing::run::{activity_map, run};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// The input scale.
const SCALE: f32 = 0.7;

/// Image size, output channels, and the auxiliary images. Sizes around the workgroup's 16; channels
/// at, below and above multiples of 4, up to 16.
const CASES: [([u32; 2], usize, Inputs); 6] = [
    ([1, 1], 1, Inputs::ALL),
    ([16, 16], 16, Inputs { albedo: true, normal: false }),
    ([17, 15], 8, Inputs { albedo: false, normal: true }),
    ([33, 40], 12, Inputs { albedo: false, normal: false }),
    ([48, 31], 5, Inputs::ALL),
    ([70, 20], 13, Inputs::ALL),
];

/// A convolution and its input images.
struct Problem {
    color: Image,
    auxiliary: [Option<Image>; 2],
    params: Params,
}

impl Problem {
    fn new(([width, height], outputs, inputs): ([u32; 2], usize, Inputs)) -> Self {
        let mut random = Random::new(u64::from(width) * 31 + outputs as u64);
        let mut image = |value: fn(f32) -> f32| {
            let pixel = |_| [0; 3].map(|_| value(random.value()));
            Image::new(width, height, (0..width * height).map(pixel).collect()).expect("it fits")
        };
        let color = image(|v| (v * 6.0).exp2());
        let (albedo, normal) = (image(f32::abs), image(|v| v));
        let weight = random.values(outputs * inputs.channels() * 9);
        let params = Params { weight, bias: random.values(outputs) };
        let auxiliary = [inputs.albedo.then_some(albedo), inputs.normal.then_some(normal)];
        Self { color, auxiliary, params }
    }

    fn outputs(&self) -> usize {
        self.params.bias.len()
    }

    /// The kernel's output as required by `need`, in a tensor that was all −77.
    fn run(&self, (kernels, precision): (KernelSet, Precision), need: &Need<'_>) -> Tensor {
        self.record(precision, |context, sources, sides| {
            let map = channel_map(self.outputs());
            let output = Tensor::from_fn(self.outputs(), sides[1], sides[0], |_, _, _| -77.0);
            let output = upload(context, &output, &map);
            let operator = InputConv::new(context, kernels, &self.params);
            let call = operator.dispatch(context, sources, &output, need);
            submit(context, |pass| call.record_at(pass, 0));
            download(context, &output, &map)
        })
    }

    /// The output of the two kernels that this one replaces.
    fn run_apart(&self, kernels: KernelSet) -> Tensor {
        let input = self.record(Precision::F32, |context, sources, [width, height]| {
            let map = input_process::channel_map(sources.inputs().channels());
            let quads = map.len() as u32 / 4;
            let texture = GpuTensor::texture(context, [width as u32, height as u32], quads);
            let output = GpuTensor::of(&texture, 0, quads);
            let call = input_process(context, sources, &output);
            submit(context, |pass| call.record_at(pass, 0));
            download(context, &output, &map)
        });
        let (context, map) = (context(Precision::F32), input_process::channel_map(input.channels));
        let conv = conv3x3(context, kernels, &self.params, &map, true, false);
        run(context, &conv, &input, &map, [self.outputs(), input.height, input.width])
    }

    /// Binds the images and calls `make`, with the sides of the tensor.
    fn record<T>(
        &self,
        precision: Precision,
        make: impl FnOnce(&wgdenoise::internals::gpu::kernel::Context, &Sources<'_>, [usize; 2]) -> T,
    ) -> T {
        let context = context(precision);
        let (width, height) = self.color.size();
        let layout = Layout::packed(width);
        let (color, albedo, normal) = (layout, layout, layout);
        let tile = Tile { image_size: [width, height], color, albedo, normal, ..Tile::default() };
        let upload = |image: &Image| buffer(context, bytemuck::cast_slice(image.pixels()));
        let [albedo, normal] = self.auxiliary.each_ref().map(|image| image.as_ref().map(upload));
        let color = upload(&self.color);
        let sources = Sources {
            tiles: &buffer(context, bytemuck::bytes_of(&tile)),
            color: (&color).into(),
            albedo: albedo.as_ref().map(Into::into),
            normal: normal.as_ref().map(Into::into),
            unorm_normal: false,
            input_scale: &buffer(context, bytemuck::bytes_of(&SCALE)),
            encoding: Encoding::default(),
        };
        make(context, &sources, [width, height].map(|side| side.next_multiple_of(16) as usize))
    }

    /// The reference, using the weights as the kernels of a set multiply them.
    fn expected(&self, kernels: KernelSet) -> Tensor {
        let auxiliary = self.auxiliary.each_ref().map(Option::as_ref);
        let Params { weight, bias } = &self.params;
        let params = Params { weight: factors(kernels, weight), bias: bias.clone() };
        reference::input_conv(&self.color, auxiliary, &params, SCALE, 16)
    }

    /// Each input is off by up to 2e-6, as in `input_process`; with 16-bit factors, inputs below 2
    /// are off by 2⁻¹¹ more. The errors of a sum of `n` products with weights up to 1 add up like
    /// `√n`, and then the sum is rounded.
    fn tolerance(&self, (kernels, precision): (KernelSet, Precision)) -> Tolerance {
        let terms = self.params.weight.len() / self.outputs();
        let sum = convolution_tolerance(terms, (kernels, precision));
        let is_rounded = factors(kernels, &[1.0 / 3.0]) != [1.0 / 3.0];
        let input = if is_rounded { 2e-6 + 1.0 / 2048.0 } else { 2e-6 };
        Tolerance { absolute: sum.absolute + input * (terms as f32).sqrt(), ..sum }
    }
}

/// The kernel sets with this operator.
fn sets(precision: Precision) -> Vec<KernelSet> {
    kernel_sets(precision).into_iter().filter(|set| set.is_for_gpus()).collect()
}

fn check(problem: &Problem, variant: (KernelSet, Precision)) -> Result<(), String> {
    let map = everything(&context(variant.1).device);
    let found = problem.run(variant, &Need { map: &map, level: 0, reach: 0 });
    compare(&found, &problem.expected(variant.0), problem.tolerance(variant))
}

#[test]
fn input_conv_equals_the_reference_on_every_shape() {
    let variants = variants_of(sets);
    let cases = CASES.iter().flat_map(|case| variants.iter().map(|variant| (*case, *variant)));
    run_cases(cases, |&(case, variant)| check(&Problem::new(case), variant));
}

#[test]
fn input_conv_equals_the_two_kernels_that_it_replaces() {
    run_cases(sets(Precision::F32), |&kernels| {
        let problem = Problem::new(CASES[4]);
        let map = everything(&context(Precision::F32).device);
        let variant = (kernels, Precision::F32);
        let found = problem.run(variant, &Need { map: &map, level: 0, reach: 0 });
        compare(&found, &problem.run_apart(kernels), problem.tolerance(variant))
    });
}

#[test]
fn a_kernel_with_a_wrong_weight_fails_the_comparison() {
    for variant in variants_of(sets) {
        let problem = Problem::new(CASES[5]);
        let mut wrong = Problem::new(CASES[5]);
        wrong.params.weight[100] += 0.1;
        let map = everything(&context(variant.1).device);
        let found = wrong.run(variant, &Need { map: &map, level: 0, reach: 0 });
        compare(&found, &problem.expected(variant.0), problem.tolerance(variant)).unwrap_err();
    }
}

/// Blocks beyond the reach are left unchanged.
#[test]
fn blocks_that_nobody_needs_are_not_computed() {
    run_cases(sets(Precision::F32), |&kernels| {
        let problem = Problem::new(([64, 16], 4, Inputs::ALL));
        let map = activity_map(context(Precision::F32), [4, 1], &[0, 1, 2, 2]);
        let variant = (kernels, Precision::F32);
        let found = problem.run(variant, &Need { map: &map, level: 0, reach: 1 });
        let computed = problem.expected(kernels);
        let value = |c, y, x| if x < 32 { computed.at(c, y, x) } else { -77.0 };
        let expected = Tensor::from_fn(4, 16, 64, value);
        compare(&found, &expected, problem.tolerance(variant))
    });
}
