//! Time run backwards, `s = −t`, which is exact in floating point.

use crate::grid::Grid;
use crate::input::{Input, Side};

/// The input of a backward solve: `u(−s)`, and after it a flag that says from which side of the time `t`
/// it was read (1 for the left), which the adjoint needs to pull cotangents back to the parameters of
/// the input.
pub(super) struct ReversedInput<'a, I> {
    input: &'a I,
    /// Jumps and stops in `t`, increasing.
    ends_s: Vec<f64>,
}

impl<'a, I: Input<f64>> ReversedInput<'a, I> {
    /// Backward steps end where the input jumped in the forward solve, and at its stops.
    pub(super) fn new(input: &'a I, grid: &Grid, stops_s: &[f64]) -> Self {
        let mut ends_s: Vec<f64> = grid.jumps_s().chain(stops_s.iter().copied()).collect();
        ends_s.sort_by(f64::total_cmp);
        Self { input, ends_s }
    }
}

impl<I: Input<f64>> Input<f64> for ReversedInput<'_, I> {
    fn input_len(&self) -> usize {
        self.input.input_len() + 1
    }

    fn value_into(&self, s: f64, side: Side, out: &mut [f64]) {
        let m = self.input.input_len();
        // What lies before a time lies after it backwards.
        let side = match side {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        };
        self.input.value_into(-s, side, &mut out[..m]);
        out[m] = f64::from(u8::from(side == Side::Left));
    }

    fn next_jump(&self, s: f64) -> Option<f64> {
        let before = self.ends_s.partition_point(|&t| t < -s);
        before.checked_sub(1).map(|i| -self.ends_s[i])
    }
}

/// The side that the flag of a [`ReversedInput`] means.
pub(super) fn side_of(flag: f64) -> Side {
    if flag == 1.0 { Side::Left } else { Side::Right }
}
