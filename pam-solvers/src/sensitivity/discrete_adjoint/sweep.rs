//! The reverse sweep over a grid: the transposed steps with the vector–Jacobian products of a field.

use crate::grid::Grid;
use crate::input::ParametricInput;
use crate::observations::Observations;
use crate::sensitivity::Problem;
use crate::step::combine_into;
use crate::tableau::{Tableau, Transpose};
use pam_autodiff::{At, Cotangent, DifferentiableField};

/// Memory of a sweep, kept between gradients.
#[derive(Debug, Clone, Default)]
pub(super) struct SweepMemory {
    transpose: Transpose,
    /// State of a stage.
    stage: Vec<f64>,
    u: Vec<f64>,
    u_bar: Vec<f64>,
}

impl SweepMemory {
    fn restart(&mut self, tableau: &Tableau, n: usize, inputs: usize) {
        self.transpose.restart(tableau, n);
        self.stage.resize(n, 0.0);
        self.u.resize(inputs, 0.0);
        self.u_bar.resize(inputs, 0.0);
    }
}

/// The reverse sweep over the steps of a grid; see [`Transpose`].
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
    memory: &'a mut SweepMemory,
    /// Cotangent of the field's parameters.
    pub(super) parameters: Vec<f64>,
    /// Cotangent of the input's parameters.
    pub(super) input_parameters: Vec<f64>,
    /// Products so far.
    pub(super) vjps: usize,
}

impl<'a, V: DifferentiableField, I: ParametricInput> Sweep<'a, V, I> {
    /// The sweep over `grid`, the accepted steps of `problem`, with its field differentiated as `field`.
    pub(super) fn new<F>(
        problem: &Problem<'a, F, I>,
        grid: &'a Grid,
        field: V,
        cotangents: &'a [f64],
        memory: &'a mut SweepMemory,
    ) -> Self {
        let (tableau, input) = (problem.integrator.tableau(), problem.input);
        memory.restart(tableau, field.state_len(), input.input_len());
        Self {
            tableau,
            grid,
            input,
            field_work: field.workspace(),
            observations: Observations { times_s: problem.observations_s },
            cotangents,
            left: problem.observations_s.len(),
            memory,
            parameters: vec![0.0; field.parameter_len()],
            input_parameters: vec![0.0; input.parameter_len()],
            vjps: 0,
            field,
        }
    }

    /// Goes back over step `step`, which began in state `y` and has the stage derivatives `k` (further
    /// numbers after the `s` stages are ignored).
    pub(super) fn reverse(&mut self, step: usize, y: &[f64], k: &[f64]) {
        let (t, t_new) = self.grid.step_s(step);
        let (tableau, h) = (self.tableau, t_new - t);
        let SweepMemory { transpose, stage, u, u_bar } = &mut *self.memory;
        let (observations, cotangents) = (self.observations, self.cotangents);
        self.left = transpose.observe::<0>(t, t_new, observations, cotangents, self.left);
        let has_fsal = transpose.reaches_fsal();
        transpose.reverse::<0>(tableau, h, has_fsal, self.grid.is_restart(step), |i, k_bar, g| {
            combine_into(tableau.row(i), h, y, k, stage);
            let (t, side) = tableau.stage_time(i, t, t_new);
            self.input.value_into(t, side, u);
            g.fill(0.0);
            u_bar.fill(0.0);
            self.field.vjp_into(
                At { t, y: stage, u },
                k_bar,
                Cotangent { y: g, u: u_bar, p: &mut self.parameters },
                &mut self.field_work,
            );
            if !self.input_parameters.is_empty() {
                self.input.vjp_into(t, side, u_bar, &mut self.input_parameters);
            }
            self.vjps += 1;
        });
    }

    /// Adds the cotangent of an observation at the start of the grid.
    pub(super) fn finish(&mut self) {
        if self.left > 0 {
            let n = self.state().len();
            self.memory.transpose.observe_state(&self.cotangents[..n]);
            self.left = 0;
        }
    }

    /// ȳ, the cotangent of the state.
    pub(super) fn state(&self) -> &[f64] {
        self.memory.transpose.state()
    }
}
