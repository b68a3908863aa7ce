use wgdenoise::Precision;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::channel_map::channel_map;
use wgdenoise::internals::ops::output_process::{ResultImages, output_process};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference;

use wgdenoise_testing::gpu::{buffer, context, read_back, stored, submit, upload};
use wgdenoise_testing::{Random, Tolerance, compare, image_tensor, run_cases};

/// The bright part of the curve is `exp(16.3·x)`: an error of 1e-7 in `x` and the few units that
/// WGSL allows `exp` amount to a few 1e-6 of the result.
const TOLERANCE: Tolerance = Tolerance { absolute: 1e-9, relative: 2e-5 };

/// For curves without a logarithmic range: the largest result is 1, or 0 is a difference of ones.
const EVEN: Tolerance = Tolerance { absolute: 5e-7, relative: 2e-5 };

/// Width, height, precision.
const CASES: [(u32, u32, Precision); 5] = [
    (1, 1, Precision::F32),
    (17, 15, Precision::F32),
    (17, 15, Precision::F16),
    (32, 48, Precision::F32),
    (5, 33, Precision::F16),
];

#[test]
fn output_process_equals_the_reference_and_crops() {
    run_cases(CASES, |&(width, height, precision)| {
        let context = context(precision);
        let sides = [width, height].map(|side| side.next_multiple_of(16) as usize);
        let mut tensor = Random::new(11).tensor(3, sides[1], sides[0]);
        // Exceeds 1, for light above 65504.
        tensor.data.iter_mut().for_each(|v| *v = 1.5 * v.abs());
        let tensor = stored(&tensor, precision);
        let bounds = [false, true];
        let encodings = TransferFunction::ALL.into_iter().flat_map(|transfer_function| {
            bounds.map(|unbounded| Encoding { transfer_function, unbounded, ..Encoding::default() })
        });
        for encoding in encodings {
            let found = run(context, encoding, &tensor, [width, height], 2.5);
            let expected = reference::output_process_in(encoding, &tensor, 2.5, width, height);
            let is_pu = encoding.transfer_function == TransferFunction::Pu;
            let allowed = if is_pu { TOLERANCE } else { EVEN };
            compare(&found, &image_tensor(&expected), allowed)?;
        }
        Ok(())
    });
}

#[test]
fn only_the_pixels_of_the_tile_are_stored() {
    let context = context(Precision::F32);
    let tile = Tile {
        image_size: [8, 8],
        origin: [2, 3],
        begin: [3, 4],
        end: [6, 8],
        output: Layout::new(5, 40, 4),
        ..Tile::default()
    };
    let tensor = reference::Tensor::from_fn(3, 16, 16, |_, _, _| 0.5);
    let found = store(context, Encoding::default(), &tensor, &tile, 1.0, 5 + 8 * 40);
    for (i, value) in found.iter().enumerate() {
        let (x, y, c) =
            ((i.wrapping_sub(5)) % 40 / 4, i.wrapping_sub(5) / 40, i.wrapping_sub(5) % 4);
        let inside = i >= 5 && (3..6).contains(&x) && (4..8).contains(&y) && c < 3;
        assert_eq!(*value != -1.0, inside, "element {i}, column {x}, row {y}, channel {c}");
    }
}

fn run(
    context: &wgdenoise::internals::gpu::kernel::Context,
    encoding: Encoding,
    tensor: &reference::Tensor,
    size: [u32; 2],
    input_scale: f32,
) -> reference::Tensor {
    let tile =
        Tile { image_size: size, end: size, output: Layout::packed(size[0]), ..Tile::default() };
    let [width, height] = size.map(|side| side as usize);
    let values = store(context, encoding, tensor, &tile, input_scale, width * height * 3);
    reference::Tensor::from_fn(3, height, width, |c, y, x| values[(y * width + x) * 3 + c])
}

/// The output buffer of `count` elements, initially all −1.
fn store(
    context: &wgdenoise::internals::gpu::kernel::Context,
    encoding: Encoding,
    tensor: &reference::Tensor,
    tile: &Tile,
    input_scale: f32,
    count: usize,
) -> Vec<f32> {
    let input = upload(context, tensor, &channel_map(3));
    let image = buffer(context, bytemuck::cast_slice(&vec![-1.0_f32; count]));
    let tiles = buffer(context, bytemuck::bytes_of(tile));
    let scale = buffer(context, bytemuck::bytes_of(&input_scale));
    let color = buffer(context, bytemuck::cast_slice(&vec![0.0_f32; count]));
    let images = ResultImages {
        tiles: &tiles,
        input_scale: &scale,
        color: (&color).into(),
        output: (&image).into(),
        blend: &buffer(context, &[0; 4]),
        encoding,
    };
    let call = output_process(context, &input, &images);
    submit(context, |pass| call.record_at(pass, 0));
    let bytes = read_back(context, image.size(), |encoder, target| {
        encoder.copy_buffer_to_buffer(&image, 0, target, 0, image.size());
    });
    bytemuck::pod_collect_to_vec(&bytes)
}
