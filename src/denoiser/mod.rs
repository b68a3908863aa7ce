//! Device, weights and options: what serves images of any size.

mod blocking;
pub(crate) mod frame;
pub(crate) mod options;
pub(crate) mod pass;
pub mod self_test;
mod tile_buffers;
mod tiling;
pub(crate) mod verify;

use std::collections::HashMap;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex};

use crate::error::Result;
use crate::gpu::kernel::Context;
use crate::gpu::kernel_set::KernelSet;
use crate::gpu::precision::Precision;
use crate::model::{Inputs, Weights};
use crate::network::compile::CompiledNetwork;
use crate::ops::conv3x3::conv3x3;
use options::Options;
use self_test::self_test;

/// Compiled kernels and weights on a device of the caller's.
///
/// Denoises images on the CPU by [`denoise`](Self::denoise), and makes a
/// [`Pass`](crate::Pass) for images on the GPU by [`pass`](Self::pass). The queue is written
/// to; only the blocking call and the test of matrix kernels submit.
#[derive(Debug)]
pub struct Denoiser {
    pub(crate) context: Context,
    pub(crate) options: Options,
    notices: Mutex<Vec<String>>,
    /// Most pixels of a tile that the adapter's memory has shown to allow.
    most_pixels: AtomicU64,
    weights: Weights,
    networks: Mutex<HashMap<Inputs, Arc<CompiledNetwork>>>,
}

impl Denoiser {
    /// Uploads the weights and compiles the network's kernels for all inputs that these were trained
    /// with. The few kernels that read or write images are compiled for the images' formats by the
    /// first [`pass`](Self::pass) or [`denoise`](Self::denoise), or by
    /// [`warm_up`](Self::warm_up). For the fastest
    /// kernels the device needs [`required_features`](crate::required_features) and, for large
    /// tiles, [`required_limits`](crate::required_limits). Matrix kernels need
    /// [`matrix_features`](crate::matrix_features) and [`Options::matrix`], and are tested first by a
    /// small convolution, which is submitted and waited for.
    ///
    /// # Errors
    /// If the device cannot hold the weights or compile the kernels.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        weights: &Weights,
        options: &Options,
    ) -> Result<Self> {
        let context = Context::new(device, queue, options.precision)
            .with_pipeline_cache(options.pipeline_cache.clone())
            .with_timeout(options.timeout);
        let test = |shape| {
            self_test(&context, |params, map| {
                conv3x3(&context, KernelSet::Matrix(shape), params, map, true, false)
            })
        };
        let name = device.adapter_info().name;
        let chosen = options.choose(&name, |set| set.runs_on(device), test)?;
        let is_auto = options.kernels == KernelSet::Auto;
        let slow = is_auto.then(|| KernelSet::lost_speed(device)).flatten();
        let notices = chosen.notices.into_iter().chain(slow).collect();
        let denoiser = Self {
            context,
            options: options.clone().kernels(chosen.kernels),
            notices: Mutex::new(notices),
            most_pixels: AtomicU64::new(u64::MAX),
            weights: weights.clone(),
            networks: Mutex::default(),
        };
        denoiser.network(weights.metadata().inputs)?;
        Ok(denoiser)
    }

    /// The weights it was made with.
    #[must_use]
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// The options it runs with; their kernels are [`kernels`](Self::kernels).
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The kernels that run: [`Options::kernels`] unless that was `Auto` or failed its test.
    #[must_use]
    pub fn kernels(&self) -> KernelSet {
        self.options.kernels
    }

    /// How tensors are stored.
    #[must_use]
    pub fn precision(&self) -> Precision {
        self.options.precision
    }

    /// What the caller may want to know, one sentence each; each is returned once. There is a notice if
    /// the device lacks a feature that would make it faster, if the matrix kernels failed their test
    /// and others run, and if the adapter ran out of memory and tiles are smaller from then on.
    ///
    /// # Panics
    /// If another thread panicked in this call.
    pub fn take_notices(&self) -> Vec<String> {
        std::mem::take(&mut self.notices.lock().expect("nobody panics with it"))
    }

    /// The network for these inputs, compiled at its first use.
    pub(crate) fn network(&self, inputs: Inputs) -> Result<Arc<CompiledNetwork>> {
        let mut networks = self.networks.lock().expect("no network failed to compile");
        if let Some(network) = networks.get(&inputs) {
            return Ok(network.clone());
        }
        let weights = self.weights.for_inputs(inputs)?;
        let build = || CompiledNetwork::new(&self.context, self.options.kernels, &weights);
        let network = Arc::new(self.context.catch(build)?);
        networks.insert(inputs, network.clone());
        Ok(network)
    }
}
