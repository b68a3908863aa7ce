//! Waits for a device, which may be slow, hung or lost.

use super::kernel::Context;
use crate::error::{Error, Result};
use crate::panics::caught;

/// Waits until all submitted work is done and its staging memory is free.
pub(crate) fn wait(context: &Context) -> Result<()> {
    wait_for(context, None)
}

/// Waits for one submission, or for the last one.
///
/// # Errors
/// Fails if that takes longer than the context's timeout, or the device is lost.
pub(crate) fn wait_for(context: &Context, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
    let wait =
        wgpu::PollType::Wait { submission_index: submission, timeout: Some(context.timeout) };
    // wgpu panics if the driver reports the device lost during the wait.
    match caught(|| context.device.poll(wait)) {
        Some(Ok(_)) => Ok(()),
        Some(Err(wgpu::PollError::Timeout)) => Err(hung(context)),
        Some(Err(error)) => Err(Error::device(NO_RESULT, error)),
        None => Err(Error::DeviceLost { source: None }),
    }
}

/// Waits for all submitted work and passes the contents of a mappable buffer to `look`.
pub(crate) fn read<T>(
    context: &Context,
    buffer: &wgpu::Buffer,
    look: impl FnOnce(&[u8]) -> T,
) -> Result<T> {
    let slice = buffer.slice(..);
    slice.map_async(wgpu::MapMode::Read, |_| {});
    wait(context)?;
    let view = slice.get_mapped_range().map_err(|error| Error::device(NO_RESULT, error))?;
    let seen = look(&view);
    drop(view);
    buffer.unmap();
    Ok(seen)
}

fn hung(context: &Context) -> Error {
    // Closing a queue waits for its work without a timeout; leaking a handle keeps it open for
    // good.
    std::mem::forget(context.queue.clone());
    let adapter = context.device.adapter_info().name;
    Error::Timeout { adapter, after: context.timeout }
}

const NO_RESULT: &str = "no result came back";
