use wgdenoise::internals::gpu::kernel::Context;
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::input_process::{Sources, channel_map, input_process};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference;
use wgdenoise::{Image, Precision};

use wgdenoise_testing::gpu::{buffer, context, download, submit};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

/// WGSL's `log` and `pow` are accurate to about 1e-6 of their results here, and the transfer
/// function adds a few terms of size 1.
const F32: Tolerance = Tolerance { absolute: 4e-6, relative: 4e-6 };
/// A store rounds by 2⁻¹¹ of the value.
const F16: Tolerance = Tolerance { absolute: 4e-6, relative: 1.0 / 1024.0 };

/// Width, height, albedo, normal.
const CASES: [(u32, u32, bool, bool); 7] = [
    (1, 1, true, true),
    (2, 1, false, false),
    (16, 16, true, false),
    (17, 15, true, true),
    (31, 33, false, true),
    (8, 40, false, false),
    (3, 70, true, true),
];

#[test]
fn input_process_equals_the_reference_for_every_input_set() {
    let precisions = [(Precision::F32, F32), (Precision::F16, F16)];
    let cases = CASES.iter().flat_map(|case| precisions.map(|p| (*case, p)));
    run_cases(cases, |&((width, height, albedo, normal), (precision, tolerance))| {
        let images = images(width, height);
        let aux = [albedo.then_some(&images[1]), normal.then_some(&images[2])];
        for (i, transfer_function) in TransferFunction::ALL.into_iter().enumerate() {
            let (zero_padding, unbounded) = (i % 2 == 1, i < 2);
            let gathered = i % 2 == 0;
            let encoding = Encoding { transfer_function, zero_padding, unbounded, gathered };
            let found = run(context(precision), &images[0], aux, 0.37, encoding);
            let expected =
                reference::input_process_in(encoding, &images[0], aux[0], aux[1], 0.37, 16);
            compare(&found, &expected, tolerance)?;
        }
        Ok(())
    });
}

/// Values over the whole range, and every kind of invalid color.
fn images(width: u32, height: u32) -> [Image; 3] {
    let mut random = Random::new(u64::from(width * 100 + height));
    let mut image = |scale: fn(f32) -> f32| {
        let mut pixel = || [0; 3].map(|_| scale(random.value()));
        let pixels = (0..width * height).map(|_| pixel()).collect();
        Image::new(width, height, pixels).expect("the count is right")
    };
    let mut images = [image(|v| (v * 18.0).exp2()), image(|v| v * 1.5), image(|v| v * 1.2)];
    for (i, image) in images.iter_mut().enumerate() {
        let bad =
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -3.0, 1e30, 1e-42, -f32::NAN, f32::MAX];
        for (k, value) in bad.into_iter().enumerate() {
            let count = image.pixels().len();
            image.pixels_mut()[(k * 5 + i) % count][k % 3] = value;
        }
        // The center pixel has good neighbors only two steps away.
        for (x, y) in (0..9).map(|k| (3 + k % 3, 3 + k / 3)) {
            if x < width && y < height {
                image.pixels_mut()[(y * width + x) as usize] = [f32::NAN; 3];
            }
        }
    }
    // A lamp that overflows in one channel, and is outside a small gamut in the others.
    for (x, y) in [(11, 12), (12, 12), (12, 13)] {
        if x < width && y < height {
            let lamp = [f32::INFINITY, 3e4, -8e3];
            images[0].pixels_mut()[(y * width + x) as usize] = lamp;
        }
    }
    images
}

fn run(
    context: &Context,
    color: &Image,
    aux: [Option<&Image>; 2],
    input_scale: f32,
    encoding: Encoding,
) -> reference::Tensor {
    let (width, height) = color.size();
    let layout = Layout::packed(width);
    let tile = Tile {
        image_size: [width, height],
        color: layout,
        albedo: layout,
        normal: layout,
        ..Tile::default()
    };
    let upload = |image: &Image| buffer(context, bytemuck::cast_slice(image.pixels()));
    let [albedo, normal] = aux.map(|image| image.map(upload));
    let color = upload(color);
    let sources = Sources {
        tiles: &buffer(context, bytemuck::bytes_of(&tile)),
        color: (&color).into(),
        albedo: albedo.as_ref().map(Into::into),
        normal: normal.as_ref().map(Into::into),
        unorm_normal: false,
        input_scale: &buffer(context, bytemuck::bytes_of(&input_scale)),
        encoding,
    };
    let channels = sources.inputs().channels();
    let map = channel_map(channels);
    let output = target(context, [width, height], map.len() as u32 / 4);
    let call = input_process(context, &sources, &output);
    submit(context, |pass| call.record_at(pass, 0));
    download(context, &output, &map)
}

fn target(context: &Context, size: [u32; 2], quads: u32) -> GpuTensor {
    let [width, height] = size.map(|side| side.next_multiple_of(16));
    GpuTensor::of(&GpuTensor::texture(context, [width, height], quads), 0, quads)
}
