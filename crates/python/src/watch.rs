//! Handles Python's signals and progress callback during a run that has released the interpreter.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;

/// Stops a run once a signal or the callback has raised an exception.
pub(crate) struct Watch {
    /// `progress(done, total)`.
    callback: Option<Py<PyAny>>,
    stop: AtomicBool,
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    pub(crate) fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { callback, stop: AtomicBool::new(false), raised: Mutex::new(None) }
    }

    /// The flag that stops the run.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.stop
    }

    /// Lets Python handle its signals, then calls the callback.
    pub(crate) fn step(&self, done: u64, total: u64) {
        self.guard(|py| {
            py.check_signals()?;
            if let Some(callback) = &self.callback {
                callback.call1(py, (done, total))?;
            }
            Ok(())
        });
    }

    /// Runs Python code and keeps the exception that it raises; does nothing after an earlier one.
    pub(crate) fn guard(&self, code: impl FnOnce(Python<'_>) -> PyResult<()>) {
        if self.stop.load(Ordering::Relaxed) {
            return;
        }
        if let Err(error) = Python::attach(code) {
            self.stop.store(true, Ordering::Relaxed);
            *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        }
    }

    /// Returns the kept exception, or else the outcome of the run.
    pub(crate) fn outcome<T>(&self, run: PyResult<T>) -> PyResult<T> {
        match self.raised.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => run,
        }
    }
}
