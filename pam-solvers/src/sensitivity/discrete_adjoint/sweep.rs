//! The transpose of one Runge–Kutta step after the other.

use crate::grid::Grid;
use crate::input::{ParametricInput, Side};
use crate::sensitivity::observations::Observations;
use crate::step::{combine_into, node};
use crate::tableau::Tableau;
use pam_autodiff::{At, Cotangent, DifferentiableField};

/// Memory of a sweep, kept between gradients.
#[derive(Debug, Clone, Default)]
pub(super) struct SweepMemory {
    /// ȳ, the cotangent of the state.
    y_bar: Vec<f64>,
    /// k̄, the cotangents of the derivatives of a step; that of the closing derivative is last.
    k_bar: Vec<f64>,
    /// `(∂f/∂y)ᵀ k̄_i`.
    g: Vec<f64>,
    /// Sum of the cotangents of the observations inside a step.
    inside: Vec<f64>,
    /// State of a stage.
    stage: Vec<f64>,
    u: Vec<f64>,
    u_bar: Vec<f64>,
}

impl SweepMemory {
    fn restart(&mut self, n: usize, inputs: usize, derivatives: usize) {
        let zeros = |v: &mut Vec<f64>, len: usize| {
            v.clear();
            v.resize(len, 0.0);
        };
        zeros(&mut self.y_bar, n);
        zeros(&mut self.k_bar, n * derivatives);
        zeros(&mut self.g, n);
        zeros(&mut self.inside, n);
        zeros(&mut self.stage, n);
        zeros(&mut self.u, inputs);
        zeros(&mut self.u_bar, inputs);
    }
}

/// The reverse sweep over the steps of a grid, in k̄ form, without a division by `b`:
///
/// ```text
/// k̄_i  = h b_i ȳ⁺  +  Σ over observations inside the step  h b_i(θ) w
/// for i = s … 1:   (g, p̄ +=, ū) = vjp(t_i, Y_i; k̄_i),   ȳ += g,   k̄_j += h a_ij g
/// ȳ    = ȳ⁺ + Σ g + Σ w
/// ```
///
/// The closing derivative is the first stage of the next step unless the input jumps between them, so
/// its cotangent is carried from there and pulled back once, together with what interpolation adds.
pub(super) struct Sweep<'a, V: DifferentiableField, I> {
    tableau: &'a Tableau,
    grid: &'a Grid,
    input: &'a I,
    field: V,
    field_work: V::Workspace,
    observations: Observations<'a>,
    /// Cotangents of the observed states, `[times, states]`.
    cotangents: &'a [f64],
    /// Number of observations not yet pulled back.
    left: usize,
    /// Whether the closing derivative has a cotangent from the next step.
    carried: bool,
    memory: &'a mut SweepMemory,
    /// Cotangent of the field's parameters.
    pub(super) parameters: Vec<f64>,
    /// Cotangent of the input's parameters.
    pub(super) input_parameters: Vec<f64>,
    /// Products so far.
    pub(super) vjps: usize,
}

impl<'a, V: DifferentiableField, I: ParametricInput> Sweep<'a, V, I> {
    pub(super) fn new(
        (tableau, grid): (&'a Tableau, &'a Grid),
        field: V,
        input: &'a I,
        observations: Observations<'a>,
        cotangents: &'a [f64],
        memory: &'a mut SweepMemory,
    ) -> Self {
        memory.restart(field.state_len(), input.input_len(), tableau.derivatives());
        Self {
            tableau,
            grid,
            input,
            field_work: field.workspace(),
            observations,
            cotangents,
            left: observations.times_s.len(),
            carried: false,
            memory,
            parameters: vec![0.0; field.parameter_len()],
            input_parameters: vec![0.0; input.parameter_len()],
            vjps: 0,
            field,
        }
    }

    /// Goes back over step `step`, that began in state `y` and has the stage derivatives `k` (further
    /// numbers after the `s` derivatives are ignored).
    pub(super) fn reverse(&mut self, step: usize, y: &[f64], k: &[f64]) {
        let (t, t_new) = self.grid.step_s(step);
        let fresh = self.grid.is_fresh(step);
        let (n, s, h) = (y.len(), self.tableau.stages(), t_new - t);
        let observed = self.observations.until(self.grid, step, self.left);
        self.left = observed.first;
        if observed.at_end {
            let w = &self.cotangents[observed.end * n..(observed.end + 1) * n];
            add(&mut self.memory.y_bar, 1.0, w);
        }

        self.memory.k_bar[..s * n].fill(0.0);
        if observed.any_inside() {
            self.memory.inside.fill(0.0);
            for o in observed.first..observed.end {
                let theta = (self.observations.times_s[o] - t) / h;
                let w = &self.cotangents[o * n..(o + 1) * n];
                add(&mut self.memory.inside, 1.0, w);
                for (i, k_bar) in self.memory.k_bar.chunks_exact_mut(n).enumerate() {
                    add(k_bar, h * self.tableau.interpolation_weight(i, theta), w);
                }
            }
        }
        if self.carried || observed.any_inside() {
            combine_into(&self.tableau.b, h, y, k, &mut self.memory.stage);
            self.pull_back((t_new, Side::Left), s);
        }
        for (k_bar, &b) in self.memory.k_bar.chunks_exact_mut(n).zip(&self.tableau.b) {
            add(k_bar, h * b, &self.memory.y_bar);
        }
        for i in (0..s).rev() {
            if i == 0 && !fresh {
                break;
            }
            combine_into(&self.tableau.a[i], h, y, k, &mut self.memory.stage);
            let at = if i == 0 { (t, Side::Right) } else { node(self.tableau.c[i], t, t_new) };
            self.pull_back(at, i);
            let (k_bar, g) = (&mut self.memory.k_bar, &self.memory.g);
            for (k_bar, &a) in k_bar.chunks_exact_mut(n).zip(&self.tableau.a[i]) {
                add(k_bar, h * a, g);
            }
        }
        if observed.any_inside() {
            add(&mut self.memory.y_bar, 1.0, &self.memory.inside);
        }
        // What is left of k̄_1 belongs to the closing derivative of the step before.
        self.carried = !fresh;
        if self.carried {
            self.memory.k_bar.copy_within(0..n, s * n);
        } else {
            self.memory.k_bar[s * n..].fill(0.0);
        }
    }

    /// Adds the cotangent of an observation at the start of the grid.
    pub(super) fn finish(&mut self) {
        debug_assert!(self.left <= 1 && !self.carried, "the sweep has seen all steps");
        if self.left == 1 {
            let n = self.memory.y_bar.len();
            add(&mut self.memory.y_bar, 1.0, &self.cotangents[..n]);
            self.left = 0;
        }
    }

    /// Cotangent of the state where the sweep stands.
    pub(super) fn state(&self) -> &[f64] {
        &self.memory.y_bar
    }

    /// Pulls the cotangent of derivative `i`, evaluated at the stage state, back to state, parameters
    /// and input.
    fn pull_back(&mut self, (t, side): (f64, Side), i: usize) {
        let m = &mut *self.memory;
        let n = m.g.len();
        m.g.fill(0.0);
        m.u_bar.fill(0.0);
        self.input.value_into(t, side, &mut m.u);
        self.field.vjp_into(
            At { t, y: &m.stage, u: &m.u },
            &m.k_bar[i * n..(i + 1) * n],
            Cotangent { y: &mut m.g, u: &mut m.u_bar, p: &mut self.parameters },
            &mut self.field_work,
        );
        if !self.input_parameters.is_empty() {
            self.input.vjp_into(t, side, &m.u_bar, &mut self.input_parameters);
        }
        add(&mut m.y_bar, 1.0, &m.g);
        self.vjps += 1;
    }
}

/// `sum += factor · v`.
#[inline]
fn add(sum: &mut [f64], factor: f64, v: &[f64]) {
    for (s, v) in sum.iter_mut().zip(v) {
        *s += factor * v;
    }
}
