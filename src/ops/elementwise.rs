//! What the operators without weights share: a kernel bound to input and output.

use super::operator::{Io, Operator};
use crate::gpu::kernel::{Binding, Context, Dispatch, Kernel, KernelSpec};
use crate::shader::ShaderRoot;

/// A kernel that makes one output texel per invocation.
#[derive(Debug)]
pub struct Elementwise {
    kernel: Kernel,
}

impl Elementwise {
    /// Compiles the kernel.
    #[must_use]
    pub fn new(context: &Context, spec: &KernelSpec) -> Self {
        Self { kernel: context.kernel(spec, &[]) }
    }
}

/// The kernel of the module `name`, for [`Elementwise`].
#[must_use]
pub const fn spec(name: &'static str) -> KernelSpec {
    KernelSpec {
        name: std::borrow::Cow::Borrowed(name),
        source: ShaderRoot::Module(name),
        features: std::borrow::Cow::Borrowed(&[]),
        entry: "main",
        bindings: std::borrow::Cow::Borrowed(&[Binding::TensorIn, Binding::TensorOut]),
        overrides: &[],
        workgroup: [8, 8, 1],
    }
}

impl Operator for Elementwise {
    fn dispatch(&self, device: &wgpu::Device, io: &Io<'_>) -> Option<Dispatch> {
        let (input, output) = (io.inputs[0], io.output);
        let group = self.kernel.bind(device, &[input.resource(), output.resource()]);
        Some(self.kernel.dispatch(group, [output.width, output.height, output.quads]))
    }
}
