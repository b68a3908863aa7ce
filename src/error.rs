//! Errors. Each is one sentence: what was expected, what was found, and what to do.

use std::time::Duration;

/// An error from a dependency, kept as [`source`](std::error::Error::source).
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Everything that can go wrong. The text is one sentence for a person to act on; the variant tells
/// a program how to react.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A weights file is damaged, in an unknown format, not built in, or made for other inputs.
    #[error("weights: {message}")]
    Weights {
        /// The error text.
        message: String,
        /// The parser's error.
        source: Option<Cause>,
    },
    /// An image has the wrong size, layout, format or usage, two images do not match, or an
    /// exposure is not a positive number.
    #[error("image: {0}")]
    Image(String),
    /// No adapter was found, none matches the requested name, or the adapter failed to open a
    /// device.
    #[error("adapter: {0}")]
    NoAdapter(String),
    /// The device lacks a feature that the requested kernels or measurement need.
    #[error("adapter: {0}")]
    Unsupported(String),
    /// Even the smallest tile exceeds the memory budget or the device's limits. Raise them.
    #[error("memory: {0}")]
    Budget(String),
    /// The adapter or the machine ran out of memory. Lower the budget, or free memory and try
    /// again.
    #[error("memory: {0}")]
    OutOfMemory(String),
    /// The device was lost, along with everything created on it. Open another and start over.
    #[error(
        "device: the device was lost{}; a driver reset or update, an overlong dispatch and running \
         out of memory can all cause this; open it again, and if it is lost again, use smaller \
         tiles or another adapter",
        .source.as_ref().map(|report| format!(" ({report})")).unwrap_or_default()
    )]
    DeviceLost {
        /// The last error the device reported.
        source: Option<wgpu::Error>,
    },
    /// A submission took longer than [`Options::timeout`](crate::Options::timeout). It may still be
    /// running; the device is usable again once it ends.
    #[error(
        "device: no answer from {adapter} within {after:?}; it hangs, or it is so slow that it needs \
         smaller tiles or a longer timeout"
    )]
    Timeout {
        /// The adapter's name.
        adapter: String,
        /// The timeout that was exceeded.
        after: Duration,
    },
    /// The device computes wrong results. Try 32-bit tensors, other kernels or another adapter.
    #[error("device: {0}")]
    WrongResult(String),
    /// The caller has set [`Frame::stop`](crate::Frame::stop).
    #[error("denoising was stopped")]
    Stopped,
    /// The device reported some other error, or returned no result.
    #[error("device: {message}")]
    Device {
        /// The error text.
        message: String,
        /// The device's own report.
        source: Option<Cause>,
    },
}

impl Error {
    /// A weights-file error without a source.
    pub(crate) fn weights(message: impl Into<String>) -> Self {
        Self::Weights { message: message.into(), source: None }
    }

    /// A device error returned by a wgpu call.
    pub(crate) fn device(
        what: &str,
        source: impl std::error::Error + Send + Sync + 'static,
    ) -> Self {
        Self::Device { message: format!("{what}: {source}"), source: Some(source.into()) }
    }
}

/// The result of every fallible function in this crate.
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error as _;

    #[test]
    fn an_error_keeps_what_caused_it() {
        let report =
            || wgpu::Error::Internal { source: "driver".into(), description: "gone".into() };
        let lost = Error::DeviceLost { source: Some(report()) };
        assert!(lost.source().is_some() && lost.to_string().contains("gone"), "{lost}");
        let failed = Error::device("nothing can be uploaded", report());
        assert!(
            failed.source().is_some_and(|source| failed.to_string().contains(&source.to_string()))
        );
        assert!(Error::DeviceLost { source: None }.source().is_none());
    }
}
