//! The transpose of a Runge–Kutta step: cotangents of its end and of its dense output become those of
//! its stages and of its start.

use super::{InterpolantTable, Tableau};
use crate::observations::Observations;

/// The reverse sweep over Runge–Kutta steps, last step first, in k̄ form, without a division by `b`:
///
/// ```text
/// k̄_i  = h b_i ȳ⁺  +  Σ over observations inside the step  h b_i(θ) w
/// for i = s … 1:   g = (∂f/∂y)ᵀ k̄_i at stage i,   ȳ += g,   k̄_j += h a_ij g
/// ȳ    = ȳ⁺ + Σ g + Σ w
/// ```
///
/// The FSAL stage comes first, with `ȳ⁺ += g`. Unless a step restarts, its first stage is the FSAL stage
/// of the step before: `k̄_1` is carried there and pulled back once, together with what the dense output
/// of that step adds.
///
/// Source: J. M. Sanz-Serna, *Symplectic Runge–Kutta schemes for adjoint equations, automatic
/// differentiation, optimal control, and more*, SIAM Review 58 (2016) 3–33, whose stage adjoints are
/// `k̄_i / (h b_i)`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Transpose {
    /// ȳ, the cotangent of the state.
    y: Vec<f64>,
    /// k̄, the cotangents of the stage derivatives of a step, the FSAL stage last.
    k: Vec<f64>,
    /// Σ w over the observations inside a step.
    inside: Vec<f64>,
    /// g of one stage.
    g: Vec<f64>,
    /// The FSAL stage has a cotangent.
    reaches_fsal: bool,
    interpolant: InterpolantTable,
    weights: Vec<f64>,
}

impl Transpose {
    /// Forgets all cotangents, for steps of `tableau` with `n` states.
    pub(crate) fn restart(&mut self, tableau: &Tableau, n: usize) {
        let zeros = |v: &mut Vec<f64>, len: usize| {
            v.clear();
            v.resize(len, 0.0);
        };
        zeros(&mut self.y, n);
        zeros(&mut self.k, n * tableau.stages_with_fsal());
        zeros(&mut self.inside, n);
        zeros(&mut self.g, n);
        self.reaches_fsal = false;
        self.interpolant = InterpolantTable::new(tableau);
        zeros(&mut self.weights, self.interpolant.len());
    }

    /// ȳ at the step end reached.
    pub(crate) fn state(&self) -> &[f64] {
        &self.y
    }

    /// Adds the cotangent of an observation of the state at the step end reached.
    pub(crate) fn observe_state(&mut self, cotangent: &[f64]) {
        add(&mut self.y, 1.0, cotangent);
    }

    /// Adds the cotangents of the observations of the step from `t` to `t_new`, of which `left` are not
    /// yet added; returns how many are left after it. `cotangents` are those of all observations,
    /// `[times, states]`. For `N` states, or any number if `N` is zero.
    #[inline]
    pub(crate) fn observe<const N: usize>(
        &mut self,
        t: f64,
        t_new: f64,
        observations: Observations<'_>,
        cotangents: &[f64],
        left: usize,
    ) -> usize {
        let n = if N == 0 { self.y.len() } else { N };
        let of_step = observations.until(t, t_new, left);
        let cotangent = |o: usize| &cotangents[o * n..(o + 1) * n];
        if of_step.at_end {
            add(&mut self.y[..n], 1.0, cotangent(of_step.end));
        }
        let h = t_new - t;
        for o in (of_step.first..of_step.end).rev() {
            let w = cotangent(o);
            add(&mut self.inside[..n], 1.0, w);
            self.interpolant.weights_into((observations.times_s[o] - t) / h, h, &mut self.weights);
            for (k, &weight) in self.k.chunks_exact_mut(n).zip(&self.weights) {
                add(k, weight, w);
            }
            self.reaches_fsal = true;
        }
        of_step.first
    }

    /// Returns `true` if the FSAL stage of the step has a cotangent, after [`observe`](Self::observe).
    pub(crate) fn reaches_fsal(&self) -> bool {
        self.reaches_fsal
    }

    /// Goes back over a step of size `h`. `pull(i, k̄_i, g)` writes `g = (∂f/∂y)ᵀ k̄_i` at stage `i` (the
    /// FSAL stage is stage `s`); it is called for the FSAL stage if `has_fsal`, and for the first stage if
    /// the step `restarts`.
    #[inline]
    pub(crate) fn reverse<const N: usize>(
        &mut self,
        tableau: &Tableau,
        h: f64,
        has_fsal: bool,
        restarts: bool,
        mut pull: impl FnMut(usize, &[f64], &mut [f64]),
    ) {
        let n = if N == 0 { self.y.len() } else { N };
        let s = tableau.stages();
        let (y, g, inside) = (&mut self.y[..n], &mut self.g[..n], &mut self.inside[..n]);
        let k = &mut self.k[..(s + 1) * n];
        if has_fsal {
            pull(s, &k[s * n..], g);
            add(y, 1.0, g);
        }
        for (k, &b) in k.chunks_exact_mut(n).zip(&tableau.b) {
            add(k, h * b, y);
        }
        add(y, 1.0, inside);
        for i in (1..s).rev() {
            let (before, at) = k.split_at_mut(i * n);
            pull(i, &at[..n], g);
            add(y, 1.0, g);
            for (k, &a) in before.chunks_exact_mut(n).zip(&tableau.a[i]) {
                if a != 0.0 {
                    add(k, h * a, g);
                }
            }
        }
        let (first, rest) = k.split_at_mut(n);
        if restarts {
            pull(0, first, g);
            add(y, 1.0, g);
            first.fill(0.0);
        }
        // What is left of k̄_1 belongs to the FSAL stage of the step before.
        rest[..(s - 1) * n].fill(0.0);
        rest[(s - 1) * n..].copy_from_slice(first);
        first.fill(0.0);
        inside.fill(0.0);
        self.reaches_fsal = !restarts;
    }
}

/// `sum += factor · v`.
#[inline]
fn add(sum: &mut [f64], factor: f64, v: &[f64]) {
    for (s, &v) in sum.iter_mut().zip(v) {
        *s += factor * v;
    }
}
