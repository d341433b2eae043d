//! A field with dry friction while it slides one way or sticks.

use pam_core::{DryFriction, Scalar, VectorField};

/// How a field with dry friction moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    /// In this direction, ±1.
    Slides(f64),
    /// Not at all: friction holds it.
    Sticks,
}

/// The smooth field of one mode. It takes the inputs but for the direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct InMode<'a, F> {
    pub(super) field: &'a F,
    pub(super) friction: DryFriction,
    pub(super) mode: Mode,
}

impl<S: Scalar, F: VectorField<S>> VectorField<S> for InMode<'_, F> {
    fn state_len(&self) -> usize {
        self.field.state_len()
    }

    fn input_len(&self) -> usize {
        self.field.input_len() - 1
    }

    fn work_len(&self) -> usize {
        self.field.work_len() + self.field.input_len() + self.field.state_len()
    }

    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        let DryFriction { velocity, direction } = self.friction;
        let (all, rest) = work.split_at_mut(self.field.input_len());
        let (other, work) = rest.split_at_mut(self.field.state_len());
        all[..direction].copy_from_slice(&u[..direction]);
        all[direction + 1..].copy_from_slice(&u[direction..]);
        match self.mode {
            Mode::Slides(sign) => {
                all[direction] = S::constant(sign);
                self.field.eval_into(t, y, all, dy, work);
            }
            Mode::Sticks => {
                all[direction] = S::constant(1.0);
                self.field.eval_into(t, y, all, dy, work);
                all[direction] = S::constant(-1.0);
                self.field.eval_into(t, y, all, other, work);
                // The convex combination without acceleration.
                let gap = other[velocity] - dy[velocity];
                let share = if gap.real() > 0.0 { other[velocity] / gap } else { S::constant(0.5) };
                for (forwards, &backwards) in dy.iter_mut().zip(other.iter()) {
                    *forwards = backwards + (*forwards - backwards) * share;
                }
                dy[velocity] = S::zero();
            }
        }
    }
}
