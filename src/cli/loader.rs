//! Keeps the Vulkan loader from printing what does not concern the user. The only unsafe code.

/// Without a desktop session, Mesa's device-select layer prints "error: XDG_RUNTIME_DIR is invalid"
/// and goes on. Its order of devices is not used here, so the layer is switched off, unless the
/// user has said something about it.
///
/// To be called before anything else, while the program has one thread.
#[allow(unsafe_code, reason = "std offers no safe way to set a variable for libraries of C")]
pub(super) fn silence() {
    if std::env::var_os("NODEVICE_SELECT").is_none() {
        // SAFETY: no other thread exists yet that could read the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
