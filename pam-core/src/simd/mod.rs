//! Vector instructions for plain floats, chosen at run time.
//!
//! [`Float`] is the bound of everything that runs on whole batches: `f32` or `f64`, with the vectors
//! of the machine at hand. [`gemm`] is the one matrix kernel; [`math`] holds branch-free elementary
//! functions that loops over slices vectorise.
//!
//! [`AlignedVec`] holds their operands.
//!
//! A loop body that is handed to [`arch`]`().dispatch(…)` is compiled once for each instruction set.

mod aligned;
mod float;
pub mod gemm;
pub mod math;

pub use aligned::AlignedVec;
pub use float::Float;

use pulp::Arch;
use std::sync::OnceLock;

/// The instruction set of this machine, looked up once.
#[must_use]
#[inline]
pub fn arch() -> Arch {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    *ARCH.get_or_init(Arch::new)
}

/// Rows of a batched matrix are padded to a multiple of this many numbers: a whole vector of any
/// float on any instruction set.
pub const PAD: usize = 16;

/// `len` rounded up to a whole number of vectors.
#[must_use]
pub fn padded(len: usize) -> usize {
    len.next_multiple_of(PAD)
}
