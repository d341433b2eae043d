//! The adjoint equations as a vector field in reversed time.

use super::reversed::side_of;
use crate::input::ParametricInput;
use crate::solution::DenseSolution;
use pam_autodiff::{At, Cotangent, DifferentiableField};
use pam_core::VectorField;
use std::cell::{Cell, RefCell};

/// With `s = −t` and the adjoint λ of the state,
///
/// ```text
/// dy/ds = −f            (where the state is integrated back)
/// dλ/ds = (∂f/∂y)ᵀ λ
/// dμ/ds = (∂f/∂p)ᵀ λ,   (∂u/∂q)ᵀ (∂f/∂u)ᵀ λ   (where the sums are integrated along)
/// ```
///
/// in the state `[y, λ, μ_p, μ_q]` of which the first and the last two may be absent.
///
/// Source: R. T. Q. Chen and others, *Neural Ordinary Differential Equations*, NeurIPS 2018, appendix B.
pub(super) struct AdjointField<'a, V: DifferentiableField, I> {
    field: V,
    input: &'a I,
    /// The forward solution to read the state from; absent where it is integrated back.
    forward: Option<&'a DenseSolution<f64>>,
    with_sums: bool,
    scratch: RefCell<Scratch<V::Workspace>>,
    /// Vector–Jacobian products so far.
    pub(super) vjps: Cell<usize>,
}

struct Scratch<W> {
    field: W,
    y: Vec<f64>,
    u_bar: Vec<f64>,
    /// Sums that nobody asked for.
    p_bar: Vec<f64>,
}

impl<'a, V: DifferentiableField, I: ParametricInput> AdjointField<'a, V, I> {
    pub(super) fn new(
        field: V,
        input: &'a I,
        forward: Option<&'a DenseSolution<f64>>,
        with_sums: bool,
    ) -> Self {
        let scratch = Scratch {
            field: field.workspace(),
            y: vec![0.0; field.state_len()],
            u_bar: vec![0.0; field.input_len()],
            p_bar: vec![0.0; if with_sums { 0 } else { field.parameter_len() }],
        };
        let scratch = RefCell::new(scratch);
        Self { field, input, forward, with_sums, scratch, vjps: Cell::new(0) }
    }

    /// Number of parameters of field and input.
    pub(super) fn parameter_lens(&self) -> [usize; 2] {
        [self.field.parameter_len(), self.input.parameter_len()]
    }

    /// Where λ begins in the backward state.
    pub(super) fn lambda(&self) -> usize {
        if self.forward.is_some() { 0 } else { self.field.state_len() }
    }

    /// Adds the integrand of the sums at time `t` inside a step, for the adjoint `lambda`, to `sums`.
    pub(super) fn add_integrand(&self, t: f64, lambda: &[f64], u: &mut [f64], sums: &mut [f64]) {
        let Scratch { field: work, y, u_bar, .. } = &mut *self.scratch.borrow_mut();
        let [p, _] = self.parameter_lens();
        let found = self.forward.is_some_and(|forward| forward.at_into(t, y));
        debug_assert!(found, "the backward solve stays inside the forward one");
        let side = crate::input::Side::Right;
        self.input.value_into(t, side, u);
        let mut g = vec![0.0; lambda.len()];
        u_bar.fill(0.0);
        let (p_bar, q_bar) = sums.split_at_mut(p);
        let cotangent = Cotangent { y: &mut g, u: u_bar, p: p_bar };
        self.field.vjp_into(At { t, y, u }, lambda, cotangent, work);
        self.input.vjp_into(t, side, u_bar, q_bar);
        self.vjps.set(self.vjps.get() + 1);
    }
}

impl<V: DifferentiableField, I: ParametricInput> VectorField<f64> for AdjointField<'_, V, I> {
    fn state_len(&self) -> usize {
        let sums = if self.with_sums { self.parameter_lens().iter().sum() } else { 0 };
        self.lambda() + self.field.state_len() + sums
    }

    fn input_len(&self) -> usize {
        self.field.input_len() + 1
    }

    fn eval_into(&self, s: f64, z: &[f64], u: &[f64], dz: &mut [f64], _work: &mut [f64]) {
        let Scratch { field: work, y, u_bar, p_bar } = &mut *self.scratch.borrow_mut();
        let (t, n, at_lambda) = (-s, self.field.state_len(), self.lambda());
        let (u, flag) = (&u[..u.len() - 1], u[u.len() - 1]);
        match self.forward {
            Some(forward) => {
                let found = forward.at_into(t, y);
                debug_assert!(found, "the backward solve stays inside the forward one");
            }
            None => y.copy_from_slice(&z[..n]),
        }
        dz.fill(0.0);
        let (dy, rest) = dz.split_at_mut(at_lambda);
        if !dy.is_empty() {
            self.field.eval_into(At { t, y, u }, dy, work);
            for d in dy {
                *d = -*d;
            }
        }
        let (d_lambda, sums) = rest.split_at_mut(n);
        let (p_sum, q_sum) = if self.with_sums {
            sums.split_at_mut(self.field.parameter_len())
        } else {
            (&mut p_bar[..], &mut [][..])
        };
        u_bar.fill(0.0);
        let cotangent = Cotangent { y: d_lambda, u: u_bar, p: p_sum };
        self.field.vjp_into(At { t, y, u }, &z[at_lambda..at_lambda + n], cotangent, work);
        if self.with_sums {
            self.input.vjp_into(t, side_of(flag), u_bar, q_sum);
        }
        self.vjps.set(self.vjps.get() + 1);
    }
}
