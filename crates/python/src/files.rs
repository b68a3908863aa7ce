//! Runs the command line from Python, to denoise files.

use std::ffi::OsString;
use std::sync::Arc;

use pyo3::prelude::*;
use wgdenoise_cli::host::{self, Host, Level};

use crate::errors;
use crate::watch::Watch;

/// Forwards the command line's output to Python.
struct Listener {
    watch: Arc<Watch>,
    /// A `logging.Logger`.
    logger: Py<PyAny>,
}

impl Host for Listener {
    fn message(&self, level: Level, text: &str) {
        let method = match level {
            Level::Error => "error",
            Level::Notice => "info",
        };
        self.watch.guard(|py| self.logger.call_method1(py, method, ("%s", text)).map(drop));
    }

    fn progress(&self, done: u64, total: u64) {
        self.watch.step(done, total);
    }
}

/// Denoises files as the command line does for these arguments, starting with the program's name.
#[pyfunction]
pub(crate) fn denoise_files(
    py: Python<'_>,
    words: Vec<OsString>,
    logger: Py<PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let watch = Arc::new(Watch::new(progress));
    let run = py.detach(|| {
        let listener = Listener { watch: Arc::clone(&watch), logger };
        host::denoise(&words, Box::new(listener), watch.flag())
    });
    let run = run.map_err(|failure| errors::of_program(py, &failure));
    watch.outcome(run)
}
