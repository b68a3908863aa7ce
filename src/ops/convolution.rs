//! What the three convolutions share: a kernel bound to input, output, weights and bias.

use super::packing::{Taps, bias_buffer, plain_buffer};
use super::{GpuTensor, Operator, simd};
use crate::kernel::{Binding, Context, Dispatch, Kernel, KernelSpec};

/// A convolution with its weights, ready for tensors of any size.
#[derive(Debug)]
pub struct Convolution {
    kernel: Kernel,
    weights: Weights,
    bias: wgpu::Buffer,
    grid: [u32; 3],
}

/// Weights as the chosen variant reads them.
#[derive(Debug)]
pub enum Weights {
    /// 4×4 matrices.
    Buffer(wgpu::Buffer),
    /// Texels for the lanes of a subgroup.
    Texture(wgpu::TextureView),
}

/// A variant: its kernel, its weights, and how many input pixels one invocation handles along
/// x and y and how many invocations there are along z.
pub struct Variant {
    /// The kernel.
    pub spec: KernelSpec,
    /// Its weights.
    pub weights: Weights,
    /// Input pixels per invocation along x and y, then invocations along z.
    pub grid: [u32; 3],
}

impl Variant {
    /// The readable definition: one pixel and one output quad per invocation.
    #[must_use]
    pub fn plain(context: &Context, spec: KernelSpec, taps: &Taps<'_>) -> Self {
        let weights = Weights::Buffer(plain_buffer(context, taps));
        Self { spec, weights, grid: [1, 1, taps.out_quads() as u32] }
    }

    /// The generated code for CPU drivers.
    #[must_use]
    pub fn simd(context: &Context, shape: simd::Shape, taps: &Taps<'_>) -> Self {
        let spec = simd::spec(shape, simd::quads_per_invocation(taps.outputs));
        let weights = Weights::Texture(simd::pack(context, shape, taps));
        let blocks = simd::blocks(shape, taps.outputs) as u32;
        Self { spec, weights, grid: [simd::PIXELS, 1, blocks] }
    }
}

impl Convolution {
    /// Compiles the variant's kernel with its override values.
    #[must_use]
    pub fn new(
        context: &Context,
        variant: Variant,
        bias: &[f32],
        constants: &[(&str, f64)],
    ) -> Self {
        let kernel = context.kernel(&variant.spec, constants);
        let bias = bias_buffer(context, bias);
        Self { kernel, weights: variant.weights, bias, grid: variant.grid }
    }
}

/// A kernel for [`Convolution`]: all bind the same four things.
#[must_use]
pub const fn spec(
    name: &'static str,
    source: &'static str,
    overrides: &'static [&'static str],
) -> KernelSpec {
    KernelSpec {
        name: std::borrow::Cow::Borrowed(name),
        source: std::borrow::Cow::Borrowed(source),
        entry: "main",
        bindings: &[Binding::TensorIn, Binding::TensorOut, Binding::Buffer, Binding::Buffer],
        overrides,
        workgroup: [8, 8, 1],
    }
}

impl Operator for Convolution {
    fn dispatch(
        &self,
        device: &wgpu::Device,
        input: &GpuTensor,
        output: &GpuTensor,
    ) -> Option<Dispatch> {
        let weights = match &self.weights {
            Weights::Buffer(buffer) => buffer.as_entire_binding(),
            Weights::Texture(view) => wgpu::BindingResource::TextureView(view),
        };
        let bias = self.bias.as_entire_binding();
        let resources = [input.resource(), output.resource(), weights, bias];
        let [x, y, z] = self.grid;
        let invocations = [input.width.div_ceil(x), input.height.div_ceil(y), z];
        Some(self.kernel.dispatch(self.kernel.bind(device, &resources), invocations))
    }
}
