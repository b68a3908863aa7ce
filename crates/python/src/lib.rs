//! The compiled half of the Python package `wgdenoise`. The other half, `python/wgdenoise`, is the
//! user-facing API: names, types, documentation.

#![allow(clippy::needless_pass_by_value, reason = "PyO3 passes arguments by value")]

use std::ffi::OsString;

use pyo3::prelude::*;

mod arrays;
mod errors;
mod files;
mod images;
mod network;
mod watch;

#[pymodule(name = "_wgdenoise")]
mod module {
    #[pymodule_export]
    use super::files::denoise_files;
    #[pymodule_export]
    use super::network::Network;
    #[pymodule_export]
    use super::{compare, devices, run_command};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        wgdenoise::panics::silence_caught();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

/// Name, type, backend, driver and driver version of each adapter.
#[pyfunction]
fn devices(py: Python<'_>) -> Vec<(String, String, String, String, String)> {
    let describe = |adapter: wgdenoise::wgpu::AdapterInfo| {
        let [device_type, backend] =
            [format!("{:?}", adapter.device_type), format!("{:?}", adapter.backend)];
        (adapter.name, device_type, backend, adapter.driver, adapter.driver_info)
    };
    py.detach(|| wgdenoise::Gpu::list().into_iter().map(describe).collect())
}

/// L1, PSNR, SSIM, relative MSE, SMAPE and the number of bad pixels.
#[pyfunction]
fn compare(
    py: Python<'_>,
    image: &Bound<'_, PyAny>,
    reference: &Bound<'_, PyAny>,
) -> PyResult<(f64, f64, f64, f64, f64, usize)> {
    let linear = arrays::Srgb::new(false);
    let image = arrays::rgb("image", image, &linear)?;
    let reference = arrays::rgb("reference", reference, &linear)?;
    let found = py.detach(|| wgdenoise_metrics::compare(&image, &reference));
    let found = found.map_err(|error| errors::of_engine(py, &error))?;
    Ok((found.l1, found.psnr, found.ssim, found.relmse, found.smape, found.bad))
}

/// Runs the command line with these arguments, starting with the program's name; returns its exit
/// code.
#[pyfunction]
fn run_command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| wgdenoise_cli::run_words(&words))
}
