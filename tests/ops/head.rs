use wgdenoise::internals::gpu::kernel::Context;
use wgdenoise::internals::model::{Encoding, Params};
use wgdenoise::internals::ops::activity::Activity;
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::head::Head;
use wgdenoise::internals::ops::need::everything;
use wgdenoise::internals::ops::output_process::ResultImages;
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Tensor};
use wgdenoise::{Image, KernelSet, Precision};

use wgdenoise_testing::gpu::{
    buffer, context, fused_sets, read_back, stored, submit, upload, variants_of,
};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// As for `output_process`, plus the rounding of up to 40 products, which the steep end of the
/// curve multiplies by 16.
const TOLERANCE: Tolerance = Tolerance { absolute: 1e-8, relative: 1e-4 };

/// Channels, width, height.
const CASES: [(usize, u32, u32); 5] =
    [(1, 1, 1), (8, 17, 15), (16, 40, 33), (5, 33, 16), (40, 20, 18)];

#[test]
fn head_equals_its_plain_operators_and_keeps_clean_blocks() {
    let variants = variants_of(fused_sets);
    let cases = CASES.iter().flat_map(|case| variants.iter().map(|variant| (*case, *variant)));
    run_cases(cases, |&(case, variant)| check(case, variant, true));
    run_cases(variants_of(fused_sets), |&variant| check((3, 33, 18), variant, false));
}

fn check(
    (channels, width, height): (usize, u32, u32),
    (kernels, precision): (KernelSet, Precision),
    sigmoid: bool,
) -> Result<(), String> {
    let mut random = Random::new(channels as u64);
    let sides = [width, height].map(|side| side.next_multiple_of(16));
    let input = random.tensor(channels, sides[1] as usize, sides[0] as usize);
    let input = stored(&input, precision);
    let params = Params { weight: random.values(3 * channels), bias: random.values(3) };
    let pixels = (0..width * height).map(|_| [0; 3].map(|_| random.value())).collect();
    let color = Image::new(width, height, pixels).expect("the count is right");
    let blocks = sides[0] / 16 * (sides[1] / 16);
    let clean: Vec<bool> = (0..blocks).map(|i| i % 3 == 1).collect();
    let found = run(precision, (kernels, sigmoid), &input, &params, &clean, &color);
    let expected = reference::head(&input, &params, sigmoid, 2.5, &clean, &color);
    compare(&image_tensor(&found), &image_tensor(&expected), TOLERANCE)
}

fn run(
    precision: Precision,
    (kernels, sigmoid): (KernelSet, bool),
    input: &Tensor,
    params: &Params,
    clean: &[bool],
    color: &Image,
) -> Image {
    let (width, height) = color.size();
    let (size, layout) = ([width, height], Layout::packed(width));
    let tile =
        Tile { image_size: size, end: size, color: layout, output: layout, ..Tile::default() };
    let map = channel_map(input.channels);
    let mut head = Head::new(context(precision), kernels, params, &map);
    head.sigmoid = sigmoid;
    let color: &[f32] = bytemuck::cast_slice(color.pixels());
    let output = store(context(precision), &head, input, &tile, clean, color, color.len());
    Image::new(width, height, bytemuck::pod_collect_to_vec(&output)).expect("the count is right")
}

/// The output buffer of `count` elements, initially all −1, for an input scale of 2.5.
pub(crate) fn store(
    context: &Context,
    head: &Head,
    input: &Tensor,
    tile: &Tile,
    clean: &[bool],
    color: &[f32],
    count: usize,
) -> Vec<f32> {
    let flags: Vec<u32> = clean.iter().map(|&clean| clean.into()).collect();
    let activity = Activity {
        map: everything(&context.device),
        clean: buffer(context, bytemuck::cast_slice(&flags)),
    };
    let output = buffer(context, bytemuck::cast_slice(&vec![-1.0_f32; count]));
    let color = buffer(context, bytemuck::cast_slice(color));
    let images = ResultImages {
        tiles: &buffer(context, bytemuck::bytes_of(tile)),
        input_scale: &buffer(context, bytemuck::bytes_of(&2.5_f32)),
        color: (&color).into(),
        output: (&output).into(),
        blend: &buffer(context, &[0; 4]),
        encoding: Encoding::default(),
    };
    let input = upload(context, input, &channel_map(input.channels));
    let call = head.dispatch(context, &input, &activity, &images);
    submit(context, |pass| call.record_at(pass, 0));
    let bytes = read_back(context, output.size(), |encoder, target| {
        encoder.copy_buffer_to_buffer(&output, 0, target, 0, output.size());
    });
    bytemuck::pod_collect_to_vec(&bytes)
}
