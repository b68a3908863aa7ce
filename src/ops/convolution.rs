//! Shared by all convolutions: a kernel bound to inputs, output, weights and bias, and to the
//! activity map if it can skip unneeded pixels.

use std::borrow::Cow;

use super::operator::{Io, Operator};
use super::packing::{Taps, plain_buffer};
use super::simd;
use crate::gpu::kernel::{Binding, Context, Dispatch, Kernel, KernelSpec};
use crate::gpu::kernel_set::KernelSet;
use crate::shader::ShaderRoot;

/// The tile of a workgroup of the tiled kernels, and how it is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tiling {
    /// 16×16 pixels; four input channels are staged at a time.
    Square,
    /// 32×8 pixels; eight input channels are staged at a time.
    Wide,
    /// `Square` with 16-bit floats: products of four staged input channels are summed in 16 bits,
    /// and these sums in 32.
    Half,
}

impl Tiling {
    /// All tilings.
    pub const ALL: [Self; 3] = [Self::Square, Self::Wide, Self::Half];

    /// The tiling of a kernel set. Sets without tiled kernels of their own run the square ones.
    #[must_use]
    pub fn of(kernels: KernelSet) -> Self {
        match kernels {
            KernelSet::Wide => Self::Wide,
            KernelSet::Half => Self::Half,
            _ => Self::Square,
        }
    }

    /// Width and height.
    #[must_use]
    pub fn size(self) -> [u32; 2] {
        match self {
            Self::Square | Self::Half => [16, 16],
            Self::Wide => [32, 8],
        }
    }

    /// The kernel of `module`; its name and features begin with these.
    pub(super) fn spec(
        self,
        name: &str,
        module: &'static str,
        mut features: Vec<&'static str>,
        bindings: impl Into<Cow<'static, [Binding]>>,
        overrides: &'static [&'static str],
    ) -> KernelSpec {
        let tiling = match self {
            Self::Square => "tiled",
            Self::Wide => "wide",
            Self::Half => "half",
        };
        features.extend((self != Self::Square).then_some(tiling));
        KernelSpec {
            name: format!("{name}_{tiling}").into(),
            source: ShaderRoot::Module(module),
            features: features.into(),
            entry: "main",
            bindings: bindings.into(),
            overrides,
            workgroup: [64, 1, 1],
        }
    }
}

/// Output quads per invocation of the tiled kernels.
pub const TILED_QUADS: usize = 4;

/// A convolution with its weights, ready for tensors of any size.
#[derive(Debug)]
pub struct Convolution {
    kernel: Kernel,
    weights: PackedWeights,
    bias: wgpu::Buffer,
    /// Weights and bias of a second convolution in the same kernel.
    next: Option<(PackedWeights, wgpu::Buffer)>,
    tile: [u32; 2],
    blocks: u32,
    footprint: Option<u32>,
    pools: bool,
}

/// Weights in the layout the chosen variant reads.
#[derive(Debug)]
pub enum PackedWeights {
    /// 4×4 matrices.
    Buffer(wgpu::Buffer),
    /// Texels for the lanes of a subgroup.
    Texture(wgpu::TextureView),
}

impl PackedWeights {
    /// The weights as a binding resource.
    #[must_use]
    pub fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

/// A variant of a convolution, and how it divides work among workgroups.
pub struct Variant {
    /// The kernel.
    pub spec: KernelSpec,
    /// Its weights.
    pub weights: PackedWeights,
    /// Pixels per workgroup along x and y, counted in the smaller of the first input and the
    /// output.
    pub tile: [u32; 2],
    /// Workgroups per tile, each computing part of the output channels.
    pub blocks: u32,
    /// The number of columns that the kernel skips or computes together; `None` if it computes
    /// everything.
    pub footprint: Option<u32>,
    /// Whether it also computes the max-pool of its output.
    pub pools: bool,
}

impl Variant {
    /// The readable definition: one pixel and one output quad per invocation.
    #[must_use]
    pub fn plain(context: &Context, spec: KernelSpec, taps: &Taps<'_>) -> Self {
        let weights = PackedWeights::Buffer(plain_buffer(context, taps));
        let blocks = taps.out_quads() as u32;
        Self { spec, weights, tile: [8, 8], blocks, footprint: None, pools: false }
    }

    /// For GPUs: a workgroup computes a tile of pixels, 2×2 per invocation, for one of `blocks`
    /// blocks of output quads.
    #[must_use]
    pub fn tiled(spec: KernelSpec, tiling: Tiling, weights: PackedWeights, blocks: usize) -> Self {
        let (tile, blocks) = (tiling.size(), blocks as u32);
        Self { spec, weights, tile, blocks, footprint: Some(tile[0]), pools: false }
    }

    /// Generated code for CPU drivers: `spec` for `outputs` channels, with weights from
    /// [`simd::pack`].
    #[must_use]
    pub fn simd(
        spec: KernelSpec,
        shape: simd::SimdKernel,
        weights: PackedWeights,
        outputs: usize,
    ) -> Self {
        let (tile, footprint) = (shape.tile(), Some(shape.pixels()));
        let blocks = simd::blocks(shape, outputs) as u32;
        Self { spec, weights, tile, blocks, footprint, pools: false }
    }
}

impl Convolution {
    /// Compiles the variant's kernel with its override values.
    #[must_use]
    pub fn new(
        context: &Context,
        variant: Variant,
        bias: wgpu::Buffer,
        constants: &[(&str, f64)],
    ) -> Self {
        let kernel = context.kernel(&variant.spec, constants);
        let Variant { weights, tile, blocks, footprint, pools, .. } = variant;
        Self { kernel, weights, bias, next: None, tile, blocks, footprint, pools }
    }

    /// Adds weights and bias of a second convolution that the kernel also computes.
    #[must_use]
    pub(super) fn followed_by(self, weights: PackedWeights, bias: wgpu::Buffer) -> Self {
        Self { next: Some((weights, bias)), ..self }
    }
}

/// The kernel of the module `name`, a readable definition. They all share these four bindings.
#[must_use]
pub const fn plain_spec(name: &'static str, overrides: &'static [&'static str]) -> KernelSpec {
    KernelSpec {
        name: Cow::Borrowed(name),
        source: ShaderRoot::Module(name),
        features: Cow::Borrowed(&[]),
        entry: "main",
        bindings: Cow::Borrowed(&[
            Binding::TensorIn,
            Binding::TensorOut,
            Binding::Buffer,
            Binding::Buffer,
        ]),
        overrides,
        workgroup: [8, 8, 1],
    }
}

impl Operator for Convolution {
    fn dispatch(&self, device: &wgpu::Device, io: &Io<'_>) -> Option<Dispatch> {
        let need = self.footprint.map(|footprint| {
            let need = io.need.expect("the variant reads the activity map");
            (need.map, need.buffer(device, footprint))
        });
        let (first, second) = io.inputs.split_first().expect("a convolution has an input");
        let mut resources = vec![
            first.resource(),
            io.output.resource(),
            self.weights.resource(),
            self.bias.as_entire_binding(),
        ];
        if let Some((map, need)) = &need {
            resources.push(wgpu::BindingResource::TextureView(map));
            resources.push(need.as_entire_binding());
        }
        if let Some((weights, bias)) = &self.next {
            resources.extend([weights.resource(), bias.as_entire_binding()]);
        }
        resources.extend(second.iter().map(|input| input.resource()));
        if self.pools {
            resources.push(io.pooled.expect("a pooling convolution has two outputs").resource());
        }
        // A transposed convolution dispatches over input pixels, all others over output pixels.
        let width = io.inputs[0].width.min(io.output.width);
        let height = io.inputs[0].height.min(io.output.height);
        let [x, y] = self.tile;
        let workgroups = [width.div_ceil(x), height.div_ceil(y), self.blocks];
        Some(self.kernel.dispatch_workgroups(self.kernel.bind(device, &resources), workgroups))
    }

    fn pools(&self) -> bool {
        self.pools
    }
}
