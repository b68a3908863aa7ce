//! The repaired color alone: only some of the kernels' outputs reveal negative channels and missing
//! pixels.

use wgdenoise::internals::gpu::kernel::{Binding, KernelSpec};
use wgdenoise::internals::gpu::tensor::GpuTensor;
use wgdenoise::internals::model::{Encoding, TransferFunction};
use wgdenoise::internals::ops::image::ImageBinding;
use wgdenoise::internals::ops::input_process::{scale_binding, tile_binding};
use wgdenoise::internals::ops::tile::{Layout, Tile};
use wgdenoise::internals::reference::{self, Repaired, Tensor};
use wgdenoise::internals::shader::ShaderRoot;
use wgdenoise::{Image, Precision};

use wgdenoise_testing::gpu::{buffer, context, download, submit};
use wgdenoise_testing::{Random, Tolerance, compare, run_cases};

const SOURCE: &str = "
import package::common::repair::repaired;
import package::common::tensor::TensorOut;
import package::common::tile::tile;

@group(0) @binding(5) var output: TensorOut;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < tile.image_size) {
        textureStore(output, id.xy, 0, repaired(id.xy));
    }
}
";

/// Sums of 24 values and a quotient in f32.
const TOLERANCE: Tolerance = Tolerance { absolute: 1e-5, relative: 1e-5 };

#[test]
fn repaired_color_equals_the_reference() {
    let sizes = [[1, 1], [2, 1], [7, 5], [17, 40], [64, 33]];
    let curves = [TransferFunction::Pu, TransferFunction::Signed];
    let cases = sizes.into_iter().flat_map(|size| {
        curves.into_iter().flat_map(move |curve| [0.0, 0.05, 0.6].map(|share| (size, curve, share)))
    });
    let (mut negative, mut invalid) = (0, 0);
    run_cases(cases, |&(size, transfer_function, share)| {
        let image = picture(size, share);
        let gathered = size[0] % 2 == 0;
        let encoding = Encoding { transfer_function, gathered, ..Encoding::default() };
        let expected = reference::repair_in(encoding, &image, 0.37);
        negative += expected.color.pixels().iter().flatten().filter(|&&v| v < 0.0).count();
        invalid += expected.valid.iter().filter(|&&valid| !valid).count();
        compare(&run(&image, encoding, 0.37), &tensor(&expected), TOLERANCE)
    });
    assert!(negative > 100 && invalid > 10, "{negative} negative values, {invalid} invalid pixels");
}

/// Random color, with this share of pixels replaced by everything that needs repair, plus holes and
/// lamps.
fn picture([width, height]: [u32; 2], share: f32) -> Image {
    let mut random = Random::new(u64::from(width));
    let mut pixel = || [0; 3].map(|_| random.value() + 0.8);
    let pixels = (0..width * height).map(|_| pixel()).collect();
    let mut image = Image::new(width, height, pixels).expect("the count is right");
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -9.0, 1e4, 7e4, f32::MAX, -f32::NAN];
    for (i, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let [x, y] = [i as u32 % width, i as u32 / width];
        let [value, place] = [0; 2].map(|_| (random.value().abs() * 8.0) as usize % 8);
        if random.value().abs() < share {
            pixel[place % 3] = odd[value];
        }
        match [x / 6, y / 6] {
            [1, 1] => *pixel = [f32::NAN; 3],
            [0, 3] => *pixel = [f32::INFINITY, 3e4, -8e3],
            _ => {}
        }
    }
    image
}

/// The color's channels, with its validity as a fourth.
fn tensor(repaired: &Repaired) -> Tensor {
    let Repaired { color, valid } = repaired;
    let (width, height) = color.size();
    Tensor::from_fn(4, height as usize, width as usize, |c, y, x| match c {
        3 => f32::from(valid[y * width as usize + x]),
        _ => color.row(y as u32)[x][c],
    })
}

fn run(image: &Image, encoding: Encoding, input_scale: f32) -> Tensor {
    let context = context(Precision::F32);
    let (width, height) = image.size();
    let layout = Layout::packed(width);
    let tile = Tile { image_size: [width, height], color: layout, ..Tile::default() };
    let [tiles, color, scale] = [
        bytemuck::bytes_of(&tile),
        bytemuck::cast_slice(image.pixels()),
        bytemuck::bytes_of(&input_scale),
    ]
    .map(|bytes| buffer(context, bytes));
    let output = GpuTensor::of(&GpuTensor::texture(context, [width, height], 1), 0, 1);
    let color = || ImageBinding::from(&color).resource();
    let kernel = context.kernel(&spec(), &encoding.constants());
    // Bindings 2 and 3 are not used.
    let resources =
        [tile_binding(&tiles), color(), color(), color(), scale_binding(&scale), output.resource()];
    let group = kernel.bind(&context.device, &resources);
    let call = kernel.dispatch(group, [width, height, 1]);
    submit(context, |pass| call.record_at(pass, 0));
    download(context, &output, &(0..4).map(Some).collect())
}

fn spec() -> KernelSpec {
    let uniform = Binding::Uniform { bytes: size_of::<Tile>() as u64, dynamic: true };
    let buffer = Binding::Buffer;
    KernelSpec {
        name: "repair alone".into(),
        source: ShaderRoot::Generated(SOURCE.into()),
        features: Vec::new().into(),
        entry: "main",
        bindings: [uniform, buffer, buffer, buffer, buffer, Binding::TensorOut].to_vec().into(),
        overrides: &["brightest", "outlier", "transfer_function"],
        workgroup: [8, 8, 1],
    }
}
