//! The denoiser: a device, weights and options, ready for images of any size.

mod alpha;
mod blocking;
pub(crate) mod frame;
mod kept;
pub(crate) mod options;
mod panorama;
pub(crate) mod pass;
pub(crate) mod progress;
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
use options::Options;
use self_test::self_test;
use tile_buffers::TileBuffers;

/// Compiled kernels and weights on the caller's device.
///
/// [`denoise`](Self::denoise) takes images on the CPU; [`pass`](Self::pass) makes a
/// [`Pass`](crate::Pass) over images on the GPU. Uploads write to the queue, but only the blocking
/// call and the self-test of the matrix kernels submit to it.
#[derive(Debug)]
pub struct Denoiser {
    pub(crate) context: Arc<Context>,
    pub(crate) options: Options,
    notices: Mutex<Vec<String>>,
    /// Upper bound on a tile's pixels, lowered whenever the adapter runs out of memory.
    most_pixels: AtomicU64,
    weights: Weights,
    networks: Mutex<HashMap<Inputs, Arc<CompiledNetwork>>>,
    /// Left by the last frame for the next one.
    kept: Mutex<Option<TileBuffers>>,
}

impl Denoiser {
    /// Uploads the weights and compiles the network's kernels for every input the weights were
    /// trained with. The few kernels that read or write images depend on the images' formats; the
    /// first [`pass`](Self::pass), [`denoise`](Self::denoise) or [`warm_up`](Self::warm_up)
    /// compiles those.
    ///
    /// The fastest kernels need a device with [`required_features`](crate::required_features), and
    /// large tiles one with [`required_limits`](crate::required_limits). Matrix kernels need
    /// [`matrix_features`](crate::matrix_features) and [`Options::matrix`]; a small convolution of
    /// each kind, submitted and waited for, tests them first.
    ///
    /// # Errors
    /// Fails if the chosen kernels do not run on the device, or if it cannot hold the weights or
    /// compile the kernels.
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
            let kernels = KernelSet::Matrix(shape);
            self_test(&context, |tested, params, maps| {
                tested.build(&context, kernels, params, maps)
            })
        };
        let name = device.adapter_info().name;
        let chosen = options.choose(&name, |set| set.runs_on(device), test)?;
        let is_auto = options.kernels == KernelSet::Auto;
        let slow = is_auto.then(|| KernelSet::lost_speed(device)).flatten();
        let notices = chosen.notices.into_iter().chain(slow).collect();
        let denoiser = Self {
            context: Arc::new(context),
            options: options.clone().kernels(chosen.kernels),
            notices: Mutex::new(notices),
            most_pixels: AtomicU64::new(u64::MAX),
            weights: weights.clone(),
            networks: Mutex::default(),
            kept: Mutex::default(),
        };
        denoiser.network(weights.metadata().inputs)?;
        Ok(denoiser)
    }

    /// The network's weights.
    #[must_use]
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// The options, with [`Options::kernels`] resolved as in [`kernels`](Self::kernels).
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The kernels that run: [`Options::kernels`], or a replacement if that was `Auto` or failed
    /// its test.
    #[must_use]
    pub fn kernels(&self) -> KernelSet {
        self.options.kernels
    }

    /// How tensors are stored.
    #[must_use]
    pub fn precision(&self) -> Precision {
        self.options.precision
    }

    /// Returns and clears the notices for the caller, one sentence each. A notice appears when the
    /// device lacks a feature that would make it faster, when the matrix kernels failed their test
    /// and others run instead, and when the adapter ran out of memory and tiles shrank for good.
    ///
    /// # Panics
    /// Panics if another thread panicked in this call.
    pub fn take_notices(&self) -> Vec<String> {
        std::mem::take(&mut self.notices.lock().expect("no thread panicked here"))
    }

    /// The network for these inputs, compiled on first use.
    pub(crate) fn network(&self, inputs: Inputs) -> Result<Arc<CompiledNetwork>> {
        let mut networks = self.networks.lock().expect("no thread panicked while compiling");
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
