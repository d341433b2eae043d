//! A field differentiated by one dual number after the other: slow, and as plain as can be.

use num_dual::Dual64;
use pam_autodiff::{At, Cotangent, DifferentiableField, Differentiation, Tangent};
use pam_core::{ParametricField, VectorField};

#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OneByOne;

impl<F: ParametricField> Differentiation<F> for OneByOne {
    type Field<'a>
        = OneByOneField<'a, F>
    where
        F: 'a;
    fn name(&self) -> &'static str {
        "one by one"
    }
    fn of<'a>(&'a self, field: &'a F) -> OneByOneField<'a, F> {
        OneByOneField(field)
    }
}

pub(crate) struct OneByOneField<'a, F>(&'a F);

impl<F: ParametricField> DifferentiableField for OneByOneField<'_, F> {
    type Workspace = ();
    fn state_len(&self) -> usize {
        self.0.state_len()
    }
    fn input_len(&self) -> usize {
        self.0.input_len()
    }
    fn parameter_len(&self) -> usize {
        self.0.parameter_len()
    }
    fn workspace(&self) {}
    fn eval_into(&self, at: At<'_>, dy: &mut [f64], _work: &mut ()) {
        self.0.eval_into(at.t, at.y, at.u, dy, &mut vec![0.0; self.0.work_len()]);
    }
    fn vjp_into(&self, at: At<'_>, w: &[f64], sums: Cotangent<'_>, work: &mut ()) {
        let (n, m, p) = (at.y.len(), at.u.len(), sums.p.len());
        let mut dy = vec![0.0; n];
        for k in 0..n + m + p {
            let mut e = vec![0.0; n + m + p];
            e[k] = 1.0;
            let v = Tangent { y: &e[..n], u: &e[n..n + m], p: &e[n + m..] };
            self.jvp_into(at, v, &mut dy, work);
            let dot: f64 = dy.iter().zip(w).map(|(a, b)| a * b).sum();
            match k {
                k if k < n => sums.y[k] += dot,
                k if k < n + m => sums.u[k - n] += dot,
                k => sums.p[k - n - m] += dot,
            }
        }
    }
    fn jvp_into(&self, at: At<'_>, v: Tangent<'_>, dy: &mut [f64], _work: &mut ()) {
        let lift = |x: &[f64], dx: &[f64]| -> Vec<Dual64> {
            x.iter().zip(dx).map(|(&x, &dx)| Dual64::new(x, dx)).collect()
        };
        let field = self.0.with_parameters(&lift(&self.0.parameters(), v.p));
        let mut out = vec![Dual64::from(0.0); dy.len()];
        let mut work = vec![Dual64::from(0.0); field.work_len()];
        field.eval_into(at.t, &lift(at.y, v.y), &lift(at.u, v.u), &mut out, &mut work);
        for (dy, out) in dy.iter_mut().zip(out) {
            *dy = out.eps;
        }
    }
}
