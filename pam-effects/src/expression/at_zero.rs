//! Effects that vanish where all their values are zero, differentiated there.
//!
//! A sum of terms with unknown coefficients is differentiated by these where they are zero, to see which of them would help. The effect
//! is nothing there, whatever it remembers: `∂f/∂c_k` is the term itself, and no derivative of a memory state enters. So the memory
//! states are plain numbers, which takes a small part of the time of numbers with many derivatives.

use super::joint::{Instant, VARIABLES};
use super::memory::{MOST, Memory};
use crate::effects::Point;
use pam_core::Scalar;
use pam_expression::{Inputs, Program};

/// Whether memory states need no derivatives: first derivatives of an effect that `vanishes` where its values are zero, as they are.
#[inline]
pub(super) fn is_at_zero<S: Scalar>(vanishes: bool, p: &[S]) -> bool {
    vanishes && S::HAS_SEVERAL_SLOPES && p.iter().all(|p| p.real() == 0.0)
}

/// The memory states at a point of a step, as plain numbers.
pub(super) fn moved<S: Scalar, R>(
    law: &Memory,
    p: &[S],
    at: &Point<'_, S>,
    memory: &[S],
    then: impl FnOnce(&[f64]) -> R,
) -> R {
    let mut old = [0.0; MOST];
    old.iter_mut().zip(memory).for_each(|(plain, number)| *plain = number.real());
    let evaluate = |memory: &[f64], start: bool, program: &Program, out: &mut [f64]| {
        let instant = if start { Instant::at_start(at, p, &[]) } else { Instant::new(at, p, &[]) };
        program.values(&Plain(WithPlainMemory { instant, memory }), out);
    };
    law.advance(at.since_step_s, &old[..law.len], &evaluate, then)
}

/// An instant with memory states without derivatives; the instant's own are none.
pub(super) struct WithPlainMemory<'a, S> {
    pub(super) instant: Instant<'a, S>,
    pub(super) memory: &'a [f64],
}

impl<S: Scalar> WithPlainMemory<'_, S> {
    #[inline(always)]
    fn remembered(&self, index: usize) -> Option<f64> {
        index.checked_sub(VARIABLES + self.instant.p.len()).map(|k| self.memory[k])
    }
}

impl<S: Scalar> Inputs<S> for WithPlainMemory<'_, S> {
    #[inline(always)]
    fn input(&self, index: usize) -> S {
        match self.remembered(index) {
            Some(value) => S::constant(value),
            None => self.instant.input(index),
        }
    }

    #[inline(always)]
    fn real(&self, index: usize) -> f64 {
        match self.remembered(index) {
            Some(value) => value,
            None => self.instant.real(index),
        }
    }

    #[inline(always)]
    fn add_along(&self, index: usize, slope: f64, to: &mut S) {
        if self.remembered(index).is_none() {
            self.instant.add_along(index, slope, to);
        }
    }

    fn network_n(&self, x: S, v: S) -> S {
        self.instant.network_n(x, v)
    }
}

/// The values alone.
struct Plain<'a, S>(WithPlainMemory<'a, S>);

impl<S: Scalar> Inputs<f64> for Plain<'_, S> {
    #[inline(always)]
    fn input(&self, index: usize) -> f64 {
        self.0.real(index)
    }

    fn network_n(&self, x: f64, v: f64) -> f64 {
        self.0.network_n(S::constant(x), S::constant(v)).real()
    }
}
