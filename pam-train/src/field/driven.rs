//! The input of an experiment over any scalar, with a delay.

use pam_core::Scalar;
use pam_solvers::{Input, Side};

/// Times closer than this to a delayed jump are on its other side, s: sums of times are rounded.
const ROUNDED_S: f64 = 1e-9;

/// `u(t − τ)` over any scalar. The values of `u` are constants; the derivative by the delay is `−u̇`, from differences over
/// `width_s`, in which the jumps of a held signal are slopes.
#[derive(Debug)]
pub(super) struct Driven<'a, I, S> {
    pub(super) input: &'a I,
    pub(super) delay_s: S,
    pub(super) width_s: f64,
}

impl<I: Input<f64>, S: Scalar> Driven<'_, I, S> {
    /// The time at which the input is read.
    fn read_at(&self, t: f64, side: Side) -> f64 {
        let delay = self.delay_s.real();
        match side {
            _ if delay == 0.0 => t,
            Side::Left => t - delay - ROUNDED_S,
            Side::Right => t - delay + ROUNDED_S,
        }
    }
}

impl<I: Input<f64>, S: Scalar> Input<S> for Driven<'_, I, S> {
    fn input_len(&self) -> usize {
        self.input.input_len()
    }

    fn value_into(&self, t: f64, side: Side, out: &mut [S]) {
        let mut few = [0.0; 8];
        let mut many = Vec::new();
        let values = if out.len() <= few.len() {
            &mut few[..out.len()]
        } else {
            many.resize(out.len(), 0.0);
            &mut many[..]
        };
        let at = self.read_at(t, side);
        self.input.value_into(at, side, values);
        for (o, &v) in out.iter_mut().zip(values.iter()) {
            *o = S::constant(v);
        }
        if S::NDERIV == 0 {
            return;
        }
        let deviation = self.delay_s - S::constant(self.delay_s.real());
        for (way, side) in [(-1.0, Side::Left), (1.0, Side::Right)] {
            self.input.value_into(at + 0.5 * way * self.width_s, side, values);
            for (o, &v) in out.iter_mut().zip(values.iter()) {
                *o -= deviation.scaled(way * v / self.width_s);
            }
        }
    }

    fn next_jump(&self, t: f64) -> Option<f64> {
        let delay = self.delay_s.real();
        if delay == 0.0 {
            return self.input.next_jump(t);
        }
        let next = self.input.next_jump(t - delay)?;
        if next + delay > t + 0.5 * ROUNDED_S {
            return Some(next + delay);
        }
        self.input.next_jump(next).map(|jump| jump + delay)
    }
}
