//! The operators, one by one: what the host must know of each kernel, for the planner, the
//! tests and the benches. Each has a shader and a CPU function of the same name.

pub mod activity;
pub mod autoexposure;
pub mod concat;
pub mod conv1x1;
pub mod conv3x3;
pub mod conv_head;
pub mod conv_transpose;
pub mod convolution;
pub mod elementwise;
pub mod head;
pub mod image;
pub mod input_conv;
pub mod input_process;
pub mod matrix;
pub mod max_pool;
pub mod need;
pub mod output_process;
pub mod packing;
pub mod self_test;
pub mod sigmoid;
pub mod simd;
pub mod tile;
mod transfer;
pub mod up_conv;
pub mod upsample;

use self::image::{Element, ImageFormat};
use self::matrix::Factor::{F16, F32};
use self::matrix::MatrixShape;
use self::need::Need;
use crate::kernel::{Context, Dispatch, KernelSpec};
use crate::model::{Op, Params};
use crate::options::{KernelSet, Precision};

/// A tensor on the GPU: texel `(x, y)` of array layer `q` holds channels `4q … 4q + 3`.
#[derive(Clone, Debug)]
pub struct GpuTensor {
    /// All layers of the tensor, and nothing else of the texture.
    pub view: wgpu::TextureView,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Array layers: a quarter of the channels, rounded up.
    pub quads: u32,
}

impl GpuTensor {
    /// A texture for tensors: `size` pixels, width first, of `quads` layers.
    #[must_use]
    pub fn texture(context: &Context, size: [u32; 2], quads: u32) -> wgpu::Texture {
        let [width, height] = size;
        context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tensor"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: quads },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: context.precision.texture_format(),
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Layers `first_quad .. first_quad + quads` of a texture.
    #[must_use]
    pub fn of(texture: &wgpu::Texture, first_quad: u32, quads: u32) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            base_array_layer: first_quad,
            array_layer_count: Some(quads),
            ..Default::default()
        });
        Self { view, width: texture.width(), height: texture.height(), quads }
    }

    /// Size in bytes.
    #[must_use]
    pub fn bytes(&self, precision: Precision) -> f64 {
        let texels = f64::from(self.width) * f64::from(self.height) * f64::from(self.quads);
        texels * precision.texel_bytes() as f64
    }

    /// The view as what a bind group takes.
    #[must_use]
    pub fn resource(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::TextureView(&self.view)
    }
}

/// For each stored channel of a tensor, which channel it is; `None` for padding to four.
/// The second input of a concat starts at a multiple of four, so padding can stand inside.
pub type ChannelMap = Vec<Option<usize>>;

/// The map of a tensor of `channels` channels that was not concatenated.
#[must_use]
pub fn channel_map(channels: usize) -> ChannelMap {
    (0..channels.next_multiple_of(4)).map(|c| (c < channels).then_some(c)).collect()
}

/// What an operator is bound to.
#[derive(Clone, Copy, Debug)]
pub struct Io<'a> {
    /// What it reads, in order.
    pub inputs: &'a [&'a GpuTensor],
    /// What it makes.
    pub output: &'a GpuTensor,
    /// Where the max-pool of the output goes, if the operator [pools](Operator::pools).
    pub pooled: Option<&'a GpuTensor>,
    /// Which part of the output must be made; variants that can leave out the rest need it.
    pub need: Option<Need<'a>>,
}

/// One layer's kernel with its weights, ready to be bound to tensors of any size.
pub trait Operator: Send + Sync + std::fmt::Debug {
    /// The call that makes the output, or `None` where the planner has already put the data in
    /// place.
    ///
    /// # Panics
    /// If the operator pools and `io` has no place for it, or asks what is needed and `io` does
    /// not say.
    fn dispatch(&self, device: &wgpu::Device, io: &Io<'_>) -> Option<Dispatch>;

    /// Whether the call also makes the max-pool of its output.
    fn pools(&self) -> bool {
        false
    }
}

/// The operator of a layer; `pools` if nothing but a max-pool and later layers follow, which it
/// may then include. `maps` say how each of the layer's inputs is stored; `params` are
/// its weights, which every layer with [`Op::has_weights`] needs.
#[must_use]
pub fn build(
    context: &Context,
    kernels: KernelSet,
    op: Op,
    params: &Params,
    maps: &[&ChannelMap],
    pools: bool,
) -> Box<dyn Operator> {
    match op {
        Op::Conv3x3 { relu } => {
            Box::new(conv3x3::conv3x3(context, kernels, params, maps[0], relu, pools))
        }
        Op::UpConv { ups, relu } => {
            let maps = [maps[0], maps[1]];
            Box::new(up_conv::up_conv(context, kernels, params, maps, ups, relu))
        }
        Op::ConvTranspose => Box::new(conv_transpose::conv_transpose(context, params, maps[0])),
        Op::Conv1x1 => Box::new(conv1x1::conv1x1(context, params, maps[0])),
        Op::MaxPool => Box::new(max_pool::max_pool(context)),
        Op::Upsample => Box::new(upsample::upsample(context)),
        Op::Sigmoid => Box::new(sigmoid::sigmoid(context)),
        Op::Concat => Box::new(concat::Concat),
    }
}

/// Every shader variant there is, for the test that holds declarations against sources.
#[must_use]
pub fn all_specs() -> Vec<KernelSpec> {
    let mut specs = vec![max_pool::SPEC, sigmoid::SPEC, upsample::SPEC];
    specs.extend([conv3x3::PLAIN, conv_transpose::PLAIN, conv1x1::PLAIN]);
    specs.extend([false, true].map(conv3x3::tiled_spec));
    specs.push(up_conv::TILED);
    specs.extend(simd::Shape::Conv3x3.all_quads().map(simd::conv3x3_spec));
    specs.extend(simd::Shape::UpConv.all_quads().map(simd::up_conv_spec));
    for (side, factor) in [(8, F16), (8, F32), (16, F16)] {
        let shape = MatrixShape { side, factor, lanes: 32 };
        specs.extend([16, 32].map(|channels| matrix::spec(shape, channels)));
    }
    specs.extend(image_specs());
    specs
}

/// The variants for every format that an image can have.
fn image_specs() -> Vec<KernelSpec> {
    use wgpu::TextureFormat::{Rgba16Float, Rgba32Float};
    let f16 = ImageFormat::Buffer(Element::F16);
    let textures = [Rgba16Float, Rgba32Float].map(ImageFormat::Texture);
    let [source, _] = textures;
    let mut specs = Vec::new();
    for color in [ImageFormat::F32, f16, source] {
        let images = [color, source, f16];
        specs.extend([autoexposure::bins_spec(color), autoexposure::reduce_spec(color)]);
        specs.extend(
            [activity::classify_spec, activity::settle_spec, activity::spread_spec]
                .map(|s| s(images)),
        );
        specs.extend([input_process::spec(images), input_conv::spec(images)]);
        for output in [ImageFormat::F32, f16].into_iter().chain(textures) {
            specs.push(output_process::spec(color, output));
            specs.extend([head::spec(color, output), simd::head_spec(color, output)]);
            specs.push(conv_head::tiled_spec(color, output));
            let quads = simd::Shape::ConvHead.all_quads();
            specs.extend(quads.map(|quads| simd::conv_head_spec(quads, color, output)));
        }
    }
    specs
}
