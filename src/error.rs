//! Errors: one sentence each, with what was expected, what was found and what to do.

use std::time::Duration;

/// An error from a dependency, kept as [`source`](std::error::Error::source).
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// What can go wrong. The text is one sentence for a person to act on; the variant tells a program
/// what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A weights file is damaged, of an unknown format, or not built in.
    #[error("weights: {message}")]
    Weights {
        /// The sentence.
        message: String,
        /// What the parser reported.
        source: Option<Cause>,
    },
    /// An image has a wrong size, layout, format or usage, or two images do not fit together.
    #[error("image: {0}")]
    Image(String),
    /// No adapter was found, none has the requested name, or the adapter gives no device.
    #[error("adapter: {0}")]
    NoAdapter(String),
    /// The device lacks a feature that the requested kernels or measurement need.
    #[error("adapter: {0}")]
    Unsupported(String),
    /// Even the smallest tile exceeds the memory budget or the device's limits: raise them.
    #[error("memory: {0}")]
    Budget(String),
    /// The adapter or the machine ran out of memory: lower the budget, or free some and try again.
    #[error("memory: {0}")]
    OutOfMemory(String),
    /// The device is gone and so is everything made on it: open another and start over.
    #[error(
        "device: the device was lost{}, as after a driver reset or update, too long a dispatch, or \
         when its memory runs out; open it again, and if it is lost again, use smaller tiles or \
         another adapter",
        .source.as_ref().map(|report| format!(" ({report})")).unwrap_or_default()
    )]
    DeviceLost {
        /// The device's last report.
        source: Option<wgpu::Error>,
    },
    /// A submission took longer than [`Options::timeout`](crate::Options::timeout). It may still be
    /// running; the device can be used again once it has ended.
    #[error(
        "device: no answer from {adapter} within {after:?}: it hangs, or is so slow that it needs \
         smaller tiles or a longer time-out"
    )]
    Timeout {
        /// The adapter's name.
        adapter: String,
        /// The time-out.
        after: Duration,
    },
    /// The device computes wrong results: try 32-bit tensors, other kernels or another adapter.
    #[error("device: {0}")]
    WrongResult(String),
    /// The device reported another error, or returned no result.
    #[error("device: {message}")]
    Device {
        /// The sentence.
        message: String,
        /// What the device reported.
        source: Option<Cause>,
    },
}

impl Error {
    /// An error of a weights file without a source.
    pub(crate) fn weights(message: impl Into<String>) -> Self {
        Self::Weights { message: message.into(), source: None }
    }

    /// An error of the device that some call of wgpu returned.
    pub(crate) fn device(
        what: &str,
        source: impl std::error::Error + Send + Sync + 'static,
    ) -> Self {
        Self::Device { message: format!("{what}: {source}"), source: Some(source.into()) }
    }
}

/// The result of everything in this crate that can fail.
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
