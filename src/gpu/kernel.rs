//! Compiles shaders with their constants to pipelines, and binds pipelines for dispatch.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Mutex;
use std::time::Duration;

use super::precision::Precision;
use super::scopes::catch;
use crate::error::Result;
use crate::shader::{ComposeError, LIBRARY, ShaderRoot};

/// The kind of resource that a kernel binds at one index of bind group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// Tensor to read: a storage texture array with four channels per layer.
    TensorIn,
    /// Tensor to write.
    TensorOut,
    /// A level of a kernel pyramid to read: a storage texture array of 32-bit floats, one
    /// layer, or two with an albedo.
    LightIn,
    /// A level of a kernel pyramid to write.
    LightOut,
    /// Weights as a read-only storage texture array of 32-bit floats.
    WeightTexture,
    /// Activity map to read: a texture array with one `u32` per block.
    ActivityIn,
    /// Activity map to write, as a storage texture.
    ActivityOut,
    /// Image to read, as a float texture.
    Image,
    /// Image to write, as a storage texture of this format.
    ImageOut(wgpu::TextureFormat),
    /// Read-only storage buffer.
    Buffer,
    /// Storage buffer to write.
    BufferMut,
    /// Uniform buffer, with a dynamic offset if `dynamic`.
    Uniform {
        /// Size of the struct in bytes.
        bytes: u64,
        /// Whether each dispatch brings its own offset.
        dynamic: bool,
    },
}

/// A shader and everything the host must know about it. A test compares these declarations with the
/// source as naga parses it.
#[derive(Clone, Debug)]
pub struct KernelSpec {
    /// The kernel's unique name.
    pub name: Cow<'static, str>,
    /// The module the text is composed from.
    pub source: ShaderRoot,
    /// The variant's features, from those of [`LIBRARY`]; the precision adds its own.
    pub features: Cow<'static, [&'static str]>,
    /// Name of the entry point.
    pub entry: &'static str,
    /// Bind group 0, by index.
    pub bindings: Cow<'static, [Binding]>,
    /// The overrides set by the host.
    pub overrides: &'static [&'static str],
    /// Workgroup size.
    pub workgroup: [u32; 3],
}

impl KernelSpec {
    /// The WGSL for tensors of this precision.
    ///
    /// # Errors
    /// Fails if a module cannot be composed with these features.
    pub fn wgsl(&self, precision: Precision) -> std::result::Result<String, ComposeError> {
        let mut features = self.features.to_vec();
        features.extend((precision == Precision::F16).then_some("tensor_f16"));
        LIBRARY.compose(&self.source, &features)
    }
}

/// A compiled kernel.
#[derive(Clone, Debug)]
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    workgroup: [u32; 3],
    name: String,
}

impl Kernel {
    /// Binds `resources` in the order of their binding indices.
    #[must_use]
    pub fn bind(
        &self,
        device: &wgpu::Device,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry {
            binding,
            resource: resource.clone(),
        });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.name),
            layout: &self.layout,
            entries: &entries.collect::<Vec<_>>(),
        })
    }

    /// A dispatch with enough workgroups for all `invocations`.
    #[must_use]
    pub fn dispatch(&self, bind_group: wgpu::BindGroup, invocations: [u32; 3]) -> Dispatch {
        let workgroups =
            std::array::from_fn(|axis| invocations[axis].div_ceil(self.workgroup[axis]));
        self.dispatch_workgroups(bind_group, workgroups)
    }

    /// A dispatch of this many workgroups.
    #[must_use]
    pub fn dispatch_workgroups(
        &self,
        bind_group: wgpu::BindGroup,
        workgroups: [u32; 3],
    ) -> Dispatch {
        Dispatch { pipeline: self.pipeline.clone(), bind_group, workgroups }
    }
}

/// A prepared kernel call: preparing it allocates, recording it does not.
#[derive(Clone, Debug)]
pub struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    workgroups: [u32; 3],
}

impl Dispatch {
    /// Records the call of a kernel without a dynamic uniform.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        self.record_with(pass, &[]);
    }

    /// Records the call with the dynamic uniform at byte `offset`.
    pub fn record_at(&self, pass: &mut wgpu::ComputePass<'_>, offset: u32) {
        self.record_with(pass, &[offset]);
    }

    fn record_with(&self, pass: &mut wgpu::ComputePass<'_>, offsets: &[u32]) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, offsets);
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

/// A device, its queue (only written to, never submitted to) and the kernels compiled on it.
#[derive(Debug)]
pub struct Context {
    /// The caller's device.
    pub device: wgpu::Device,
    /// The caller's queue.
    pub queue: wgpu::Queue,
    /// How tensors are stored.
    pub precision: Precision,
    /// Longest wait for a submission.
    pub(crate) timeout: Duration,
    pipeline_cache: Option<wgpu::PipelineCache>,
    kernels: Mutex<HashMap<String, Kernel>>,
}

impl Context {
    /// A context without compiled kernels.
    #[must_use]
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, precision: Precision) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            precision,
            timeout: default_timeout(device.adapter_info().device_type),
            pipeline_cache: None,
            kernels: Mutex::default(),
        }
    }

    /// Adds a pipeline cache of the same device, from which the driver may take kernels.
    #[must_use]
    pub fn with_pipeline_cache(self, pipeline_cache: Option<wgpu::PipelineCache>) -> Self {
        Self { pipeline_cache, ..self }
    }

    /// Replaces the timeout, if one is given.
    #[must_use]
    pub(crate) fn with_timeout(self, timeout: Option<Duration>) -> Self {
        Self { timeout: timeout.unwrap_or(self.timeout), ..self }
    }

    /// The kernel for a shader and its override values, compiled on first use. Ignores overrides
    /// that the shader does not have.
    ///
    /// # Panics
    /// Panics if another thread panicked while compiling a kernel.
    #[must_use]
    pub fn kernel(&self, spec: &KernelSpec, constants: &[(&str, f64)]) -> Kernel {
        let is_set = |(name, _): &&(&str, f64)| spec.overrides.contains(name);
        let constants: Vec<_> = constants.iter().filter(is_set).copied().collect();
        let key = format!("{} {constants:?}", spec.name);
        let mut kernels = self.kernels.lock().expect("no thread panicked while compiling");
        kernels.entry(key).or_insert_with(|| self.compile(spec, &constants)).clone()
    }

    /// Runs `work` and turns any error the device reports meanwhile into an error of this crate. On
    /// an error, drops all kernels, since one of them may be invalid.
    ///
    /// # Errors
    /// Fails if `work` does or the device reports an error.
    ///
    /// # Panics
    /// Panics if another thread panicked while compiling a kernel.
    pub fn catch<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let result = catch(&self.device, work);
        if result.is_err() {
            self.kernels.lock().expect("no thread panicked while compiling").clear();
        }
        result
    }

    /// The number of compiled kernels.
    #[cfg(test)]
    pub(crate) fn compiled(&self) -> usize {
        self.kernels.lock().expect("no thread panicked while compiling").len()
    }

    fn compile(&self, spec: &KernelSpec, constants: &[(&str, f64)]) -> Kernel {
        let name = spec.name.as_ref();
        let text = spec.wgsl(self.precision).expect("the tests compose every variant");
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = self.bind_group_layout(spec);
        let descriptor = wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&self.pipeline_layout(&layout)),
            module: &module,
            entry_point: Some(spec.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                // Every kernel writes its workgroup memory before it reads it.
                zero_initialize_workgroup_memory: false,
            },
            cache: self.pipeline_cache.as_ref(),
        };
        let pipeline = self.device.create_compute_pipeline(&descriptor);
        Kernel { pipeline, layout, workgroup: spec.workgroup, name: name.into() }
    }

    fn pipeline_layout(&self, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        })
    }

    fn bind_group_layout(&self, spec: &KernelSpec) -> wgpu::BindGroupLayout {
        let entry = |(binding, &kind): (u32, &Binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: binding_type(kind, self.precision.texture_format()),
            count: None,
        };
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(&spec.name),
            entries: &(0..).zip(spec.bindings.iter()).map(entry).collect::<Vec<_>>(),
        })
    }
}

/// The default time a device may take for one submission. Tiles are sized so that a submission
/// holds at most 50 GMAC on a GPU; taking a minute for it means 1.7 GFLOP/s, a 300th of the speed
/// they are sized for. On a CPU driver, one layer of a large tile may legitimately take minutes.
fn default_timeout(device_type: wgpu::DeviceType) -> Duration {
    match device_type {
        wgpu::DeviceType::Cpu => Duration::from_mins(10),
        _ => Duration::from_mins(1),
    }
}

pub(crate) fn binding_type(binding: Binding, tensor: wgpu::TextureFormat) -> wgpu::BindingType {
    use wgpu::StorageTextureAccess::{ReadOnly, WriteOnly};
    use wgpu::TextureViewDimension::{D2, D2Array};
    let texture = |format, access| wgpu::BindingType::StorageTexture {
        access,
        format,
        view_dimension: D2Array,
    };
    let sampled = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let buffer = |ty, has_dynamic_offset, bytes| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset,
        min_binding_size: std::num::NonZeroU64::new(bytes),
    };
    match binding {
        Binding::TensorIn => texture(tensor, ReadOnly),
        Binding::TensorOut => texture(tensor, WriteOnly),
        Binding::WeightTexture | Binding::LightIn => {
            texture(wgpu::TextureFormat::Rgba32Float, ReadOnly)
        }
        Binding::LightOut => texture(wgpu::TextureFormat::Rgba32Float, WriteOnly),
        Binding::ActivityIn => sampled(wgpu::TextureSampleType::Uint, D2Array),
        Binding::ActivityOut => texture(wgpu::TextureFormat::R32Uint, WriteOnly),
        Binding::Image => sampled(wgpu::TextureSampleType::Float { filterable: false }, D2),
        Binding::ImageOut(format) => {
            wgpu::BindingType::StorageTexture { access: WriteOnly, format, view_dimension: D2 }
        }
        Binding::Buffer => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false, 0),
        Binding::BufferMut => {
            buffer(wgpu::BufferBindingType::Storage { read_only: false }, false, 0)
        }
        Binding::Uniform { bytes, dynamic } => {
            buffer(wgpu::BufferBindingType::Uniform, dynamic, bytes)
        }
    }
}
