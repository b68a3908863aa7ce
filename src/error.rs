//! What can go wrong, as one sentence each: what, where, expected, found, what to do.

/// Every error of the engine. The text of each is one sentence for a person to act on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The weights file is not one that this version can run.
    #[error("weights: {0}")]
    Weights(String),
    /// An image has a wrong size or wrong values, or two images do not fit together.
    #[error("image: {0}")]
    Image(String),
    /// No adapter can run the network, or the chosen one lacks something.
    #[error("adapter: {0}")]
    Adapter(String),
    /// The work does not fit into the memory budget or the adapter's limits.
    #[error("memory: {0}")]
    Memory(String),
    /// The device failed while it worked.
    #[error("device: {0}")]
    Device(String),
}

/// The result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;
