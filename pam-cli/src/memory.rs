//! How the process takes memory from the system.

/// Lets large blocks, such as the channels of recordings, go back to the system as soon as they are free.
///
/// The allocator of the GNU C library keeps blocks of up to 32 MiB after the first of their size is freed, each in the arena of the
/// thread that made it, where other threads cannot use it: a training with 225 recordings of 70 s then takes 1250 MiB in place
/// of 850. Fixed thresholds end this (`mallopt(3)`): a block of 512 KiB or more is a mapping of its own, and up to 64 MiB of
/// smaller ones are kept for use again. Does nothing with other C libraries.
///
/// For commands that read many recordings once. Where such blocks come and go all the time, as in a diagnosis, the system would spend a
/// fifth of the time on them.
pub(crate) fn return_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    for (parameter, bytes) in
        [(libc::M_MMAP_THRESHOLD, 512 << 10), (libc::M_TRIM_THRESHOLD, 64 << 20)]
    {
        // SAFETY: `mallopt` takes two integers by value and may be called at any time; it leaves the setting as it was where it
        // cannot take the value.
        #[allow(unsafe_code)]
        unsafe {
            libc::mallopt(parameter, bytes);
        }
    }
}
