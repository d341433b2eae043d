//! One Runge–Kutta step in memory that is allocated once.

use crate::input::{Input, Side};
use crate::tableau::Tableau;
use crate::term::Term;
use pam_core::{Scalar, VectorField, scalar};

/// Scratch memory of a solve: derivatives, states, input and the field's own work.
pub(crate) struct Workspace<S> {
    /// Stage derivatives of the step, one after the other, the FSAL stage last.
    pub(crate) k: Vec<S>,
    /// State at the start of the step.
    pub(crate) y: Vec<S>,
    /// State at the end of the step.
    pub(crate) y_new: Vec<S>,
    /// Scratch state: stage states, error estimates, interpolated points.
    pub(crate) scratch: Vec<S>,
    u: Vec<S>,
    field_work: Vec<S>,
    /// Field evaluations so far.
    pub(crate) evaluations: usize,
}

impl<S: Scalar> Workspace<S> {
    pub(crate) fn new<F: VectorField<S>, I: Input<S>>(
        tableau: &Tableau,
        term: &Term<F, I>,
        y0: &[S],
    ) -> Self {
        let n = y0.len();
        Self {
            k: scalar::zeros(n * tableau.stages_with_fsal()),
            y: y0.to_vec(),
            y_new: y0.to_vec(),
            scratch: scalar::zeros(n),
            u: scalar::zeros(term.input.input_len()),
            field_work: scalar::zeros(term.field.work_len()),
            evaluations: 0,
        }
    }

    /// Evaluates the field at the start of the step into the first derivative.
    pub(crate) fn first_stage<F, I>(&mut self, term: &Term<F, I>, t: f64)
    where
        F: VectorField<S>,
        I: Input<S>,
    {
        let n = self.y.len();
        term.eval_into(
            t,
            Side::Right,
            &self.y,
            &mut self.k[..n],
            &mut self.u,
            &mut self.field_work,
        );
        self.evaluations += 1;
    }

    /// Evaluates the field at `(t, y + h k_1)` into `scratch`, for the estimate of a first step. The
    /// input is read at the start of the step.
    pub(crate) fn euler_probe<F, I>(&mut self, term: &Term<F, I>, t: f64, h: f64)
    where
        F: VectorField<S>,
        I: Input<S>,
    {
        let n = self.y.len();
        for i in 0..n {
            self.y_new[i] = self.y[i] + self.k[i].scaled(h);
        }
        term.eval_into(
            t,
            Side::Right,
            &self.y_new,
            &mut self.scratch,
            &mut self.u,
            &mut self.field_work,
        );
        self.evaluations += 1;
    }

    /// Stages two to `s` and the new state, for a step from `t` to `t_new`; the first derivative is
    /// known.
    pub(crate) fn advance<F, I>(&mut self, tableau: &Tableau, term: &Term<F, I>, t: f64, t_new: f64)
    where
        F: VectorField<S>,
        I: Input<S>,
    {
        let (n, h) = (self.y.len(), t_new - t);
        for i in 1..tableau.stages() {
            self.combine(&tableau.a[i], h);
            let (time, side) = tableau.stage_time(i, t, t_new);
            let (_, rest) = self.k.split_at_mut(i * n);
            term.eval_into(
                time,
                side,
                &self.y_new,
                &mut rest[..n],
                &mut self.u,
                &mut self.field_work,
            );
        }
        self.evaluations += tableau.stages() - 1;
        self.combine(&tableau.b, h);
    }

    /// The FSAL stage `k_{s+1} = f(t_new, y_new)`.
    pub(crate) fn fsal_stage<F, I>(&mut self, tableau: &Tableau, term: &Term<F, I>, t_new: f64)
    where
        F: VectorField<S>,
        I: Input<S>,
    {
        let n = self.y.len();
        let fsal = &mut self.k[tableau.stages() * n..];
        term.eval_into(t_new, Side::Left, &self.y_new, fsal, &mut self.u, &mut self.field_work);
        self.evaluations += 1;
    }

    /// The FSAL stage becomes the first stage of the next step.
    pub(crate) fn reuse_fsal(&mut self, tableau: &Tableau) {
        let n = self.y.len();
        let fsal = tableau.stages() * n;
        self.k.copy_within(fsal..fsal + n, 0);
    }

    /// Writes the error estimate `h Σ (b_i − b̂_i) k_i` to `scratch`.
    pub(crate) fn estimate_error(&mut self, weights: &[f64], h: f64) {
        let n = self.y.len();
        error_into(weights, h, self.k.chunks_exact(n), &mut self.scratch);
    }

    /// `y_new = y + h Σ_j weights_j k_j`.
    #[inline]
    fn combine(&mut self, weights: &[f64], h: f64) {
        combine_into(weights, h, &self.y, &self.k, &mut self.y_new);
    }
}

/// Writes the error estimate `h Σ_i weights_i k_i`, with `weights = b − b̂`, to `out`.
#[inline]
pub(crate) fn error_into<'k, S: Scalar>(
    weights: &[f64],
    h: f64,
    k: impl Iterator<Item = &'k [S]>,
    out: &mut [S],
) {
    out.fill(S::zero());
    for (ki, &w) in k.zip(weights) {
        for (e, &d) in out.iter_mut().zip(ki) {
            *e += d.scaled(h * w);
        }
    }
}

/// Writes `y + h Σ_j weights_j k_j` to `out`; `k` holds stage derivatives one after the other.
#[inline]
pub(crate) fn combine_into<S: Scalar>(weights: &[f64], h: f64, y: &[S], k: &[S], out: &mut [S]) {
    out.copy_from_slice(y);
    for (kj, &w) in k.chunks_exact(y.len()).zip(weights) {
        if w != 0.0 {
            for (o, &d) in out.iter_mut().zip(kj) {
                *o += d.scaled(h * w);
            }
        }
    }
}
