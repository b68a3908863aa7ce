//! Turns errors of the engine and the command line into Python exceptions with the same sentences.
//! The classes are in `python/wgdenoise/_errors.py`, as only Python code can give them two bases.

use pyo3::prelude::*;
use pyo3::types::PyType;
use wgdenoise::Error;
use wgdenoise_cli::Failure;

/// An engine error.
pub(crate) fn of_engine(py: Python<'_>, error: &Error) -> PyErr {
    let class = match error {
        Error::Image(_) => "ImageError",
        Error::Weights { .. } => "WeightsError",
        Error::NoAdapter(_) | Error::Unsupported(_) => "AdapterError",
        Error::Budget(_) | Error::OutOfMemory(_) => "OutOfMemoryError",
        _ => "DeviceError",
    };
    exception(py, class, &error.to_string())
}

/// A command-line error.
pub(crate) fn of_program(py: Python<'_>, failure: &Failure) -> PyErr {
    let class = match failure {
        Failure::Work(_) => "FileError",
        Failure::Usage(_) => "UsageError",
        Failure::Adapter(_) => "AdapterError",
        Failure::Device(_) | Failure::Stopped => "DeviceError",
    };
    exception(py, class, &failure.to_string())
}

/// An array that cannot be used.
pub(crate) fn of_image(py: Python<'_>, sentence: String) -> PyErr {
    of_engine(py, &Error::Image(sentence))
}

/// An argument with a value that is not allowed.
pub(crate) fn of_usage(py: Python<'_>, sentence: &str) -> PyErr {
    exception(py, "UsageError", sentence)
}

fn exception(py: Python<'_>, class: &str, sentence: &str) -> PyErr {
    let classes = py.import("wgdenoise._errors");
    let class = classes.and_then(|module| Ok(module.getattr(class)?.cast_into::<PyType>()?));
    class.map_or_else(|error| error, |class| PyErr::from_type(class, sentence.to_string()))
}
