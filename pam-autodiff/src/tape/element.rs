//! The numbers that a tape can hold, and the thread's place for the tape that records.

use super::arena::Arena;
use num_dual::Dual64;
use pam_core::Scalar;
use std::cell::RefCell;
use std::mem::ManuallyDrop;

/// A number that a [`Tape`](super::Tape) can hold: `f64`, `f32`, or [`Dual64`] for forward over
/// reverse. Sealed, because each needs a place of its own in the thread.
pub trait Element: Scalar + Place {}

/// Operations of a tape on its numbers.
pub trait Place: Sized + 'static {
    /// Runs `f` with the arena that records on this thread.
    fn with<R>(f: impl FnOnce(&mut Arena<Self>) -> R) -> R;

    /// Exchanges `arena` with the one that records on this thread.
    fn exchange(arena: &mut Arena<Self>) {
        Self::with(|recording| std::mem::swap(recording, arena));
    }

    /// Returns `true` if the number and its derivatives are exactly zero.
    fn vanishes(&self) -> bool;
}

macro_rules! element {
    ($type:ty, |$number:ident| $vanishes:expr) => {
        impl Place for $type {
            #[inline]
            fn with<R>(f: impl FnOnce(&mut Arena<Self>) -> R) -> R {
                // Without a destructor the access is a plain load. There is nothing to drop: when a
                // thread ends no tape records, and the idle arena owns no memory.
                thread_local! {
                    static RECORDING: ManuallyDrop<RefCell<Arena<$type>>> =
                        const { ManuallyDrop::new(RefCell::new(Arena::idle())) };
                }
                RECORDING.with(|recording| f(&mut recording.borrow_mut()))
            }
            #[inline]
            fn vanishes(&self) -> bool {
                let $number = self;
                $vanishes
            }
        }
        impl Element for $type {}
    };
}

element!(f64, |x| *x == 0.0);
element!(f32, |x| *x == 0.0);
element!(Dual64, |x| x.re == 0.0 && x.eps == 0.0);
