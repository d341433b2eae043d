//! The quadratic program of a horizon.
//!
//! States `s = (x, v, m_f, m_e)`, controls `u = (ṁ_f, ṁ_e)`:
//!
//! ```text
//! ẋ = v      m v̇ = d − f(x, v, m_f, m_e) − B v      ṁ_i = u_i
//! ```
//!
//! Along the trajectory predicted last, f is replaced by its tangent; each step of the horizon is then
//! linear and is discretised by the series of the matrix exponential. The states are eliminated, and the
//! flows minimise
//!
//! ```text
//! Σ_k [(x − x_d)/σ_x]² + [(v − v_d)/σ_v]² + [(m_f + m_e − planned)/σ_m]² + Σ_i (u_i/σ_u)²
//! ```
//!
//! within what the valves let through. The sum of the masses holds the stiffness, their difference the
//! motion.

use super::box_qp::BoxQp;
use super::flow::ValveModel;
use super::observer::Belief;
use crate::synthesis::{ForceBatch, MassBounds};
use pam_core::{ForceModel, JointModel, SealedMasses};
use serde::{Deserialize, Serialize};

/// Length and weights of a horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HorizonSettings {
    /// Steps.
    pub steps: usize,
    /// Length of a step, s.
    pub step_s: f64,
    /// Error of the displacement that costs one, mm.
    pub displacement_mm: f64,
    /// Error of the velocity that costs one, mm/s.
    pub velocity_mm_s: f64,
    /// Error of the total air that costs one, g.
    pub mass_g: f64,
    /// Flow that costs one, g/s.
    pub flow_g_s: f64,
}

impl Default for HorizonSettings {
    fn default() -> Self {
        Self {
            steps: 12,
            step_s: 0.01,
            displacement_mm: 0.02,
            velocity_mm_s: 1.5,
            mass_g: 0.004,
            flow_g_s: 0.05,
        }
    }
}

/// Reference at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reference {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Air in both muscles, g.
    pub total_g: f64,
}

type State = [f64; 4];
type Matrix = [[f64; 4]; 4];

/// One linear step `s⁺ = a s + b u + c`.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    a: Matrix,
    b: [[f64; 2]; 4],
    c: State,
}

/// The program with its memory.
#[derive(Debug)]
pub struct Horizon<B: ForceBatch> {
    settings: HorizonSettings,
    bounds: MassBounds,
    batch: B,
    work: B::Work,
    mass_kg: f64,
    damping_kg_s: f64,
    points: Vec<[f64; 4]>,
    forces_mn: Vec<f64>,
    slopes: Vec<[f64; 4]>,
    steps: Vec<Step>,
    /// Predicted states at the start of each step.
    predicted: Vec<State>,
    /// Columns of the states' slopes along each control, by control.
    columns: Vec<[[f64; 2]; 4]>,
    hessian: Vec<f64>,
    linear: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    flows: Vec<f64>,
    qp: BoxQp,
}

impl<B: ForceBatch> Horizon<B> {
    /// A horizon of a model.
    pub fn new<F>(
        model: &JointModel<f64, F>,
        batch: B,
        settings: HorizonSettings,
        bounds: MassBounds,
    ) -> Self {
        let (n, m) = (settings.steps, 2 * settings.steps);
        Self {
            work: batch.work(n + 1),
            batch,
            mass_kg: model.physical().mass_kg,
            damping_kg_s: model.auxiliary_damping_kg_s,
            points: vec![[0.0; 4]; n],
            forces_mn: vec![0.0; n],
            slopes: vec![[0.0; 4]; n],
            steps: vec![Step::default(); n],
            predicted: Vec::new(),
            columns: vec![[[0.0; 2]; 4]; n],
            hessian: vec![0.0; m * m],
            linear: vec![0.0; m],
            low: vec![0.0; m],
            high: vec![0.0; m],
            flows: vec![0.0; m],
            qp: BoxQp::new(m),
            settings,
            bounds,
        }
    }

    /// The force in batches, and memory for it.
    pub fn force(&mut self) -> (&B, &mut B::Work) {
        (&self.batch, &mut self.work)
    }

    /// The flows (g/s) of the first step from what is believed; `references` has one entry a step.
    /// Allocates nothing after the first call.
    ///
    /// # Panics
    /// If there are fewer references than steps.
    pub fn solve<F: ForceModel<f64>>(
        &mut self,
        model: &JointModel<f64, F>,
        belief: &Belief,
        references: &[Reference],
        valves: &ValveModel,
    ) -> [f64; 2] {
        let SealedMasses { flexor_g, extensor_g } = belief.masses;
        let start = [belief.displacement_mm, belief.velocity_mm_s, flexor_g, extensor_g];
        if self.predicted.is_empty() {
            self.predicted.resize(self.settings.steps + 1, start);
        }
        self.predicted[0] = start;
        self.linearise(belief.force_mn);
        self.limit(model, belief, valves);
        self.condense(start, references);
        let Self { qp, hessian, linear, low, high, flows, .. } = self;
        qp.solve(hessian, linear, low, high, flows);
        self.predict(start);
        [self.flows[0], self.flows[1]]
    }

    fn linearise(&mut self, unexplained_mn: f64) {
        for (point, s) in self.points.iter_mut().zip(&self.predicted) {
            *point = [s[2], s[3], s[0], s[1]];
        }
        let Self { batch, work, points, forces_mn, slopes, .. } = self;
        batch.slopes_into(points, forces_mn, slopes, work);
        for k in 0..self.settings.steps {
            let [by_f, by_e, by_x, by_v] = self.slopes[k];
            let s = self.predicted[k];
            let m = self.mass_kg;
            let tangent = self.forces_mn[k] - by_x * s[0] - by_v * s[1] - by_f * s[2] - by_e * s[3];
            let a = [
                [0.0, 1.0, 0.0, 0.0],
                [-by_x / m, -(by_v + self.damping_kg_s) / m, -by_f / m, -by_e / m],
                [0.0; 4],
                [0.0; 4],
            ];
            let c = [0.0, (unexplained_mn - tangent) / m, 0.0, 0.0];
            self.steps[k] = discretise(&a, c, self.settings.step_s);
        }
    }

    /// Bounds of the flows: what the valves let through, and what keeps the masses in their bounds.
    fn limit<F: ForceModel<f64>>(
        &mut self,
        model: &JointModel<f64, F>,
        belief: &Belief,
        valves: &ValveModel,
    ) {
        let pressures = model.gas_law_pressures_kpa(belief.displacement_mm, belief.masses);
        let masses = [belief.masses.flexor_g, belief.masses.extensor_g];
        let span = self.settings.step_s * self.settings.steps as f64;
        for i in 0..2 {
            // Spread over the horizon no flow leads out of the bounds.
            let most = valves.inflow_g_s(pressures[i]);
            let least = -valves.outflow_g_s(pressures[i]);
            let room_up = (self.bounds.most_g - masses[i]) / span;
            let room_down = (self.bounds.least_g - masses[i]) / span;
            for k in 0..self.settings.steps {
                let near = 3.0;
                self.high[2 * k + i] = most.min(near * room_up.max(0.0));
                self.low[2 * k + i] = least.max(near * room_down.min(0.0));
            }
        }
    }

    fn condense(&mut self, start: State, references: &[Reference]) {
        let n = self.settings.steps;
        let m = 2 * n;
        let s = &self.settings;
        let weights =
            [s.displacement_mm, s.velocity_mm_s, s.mass_g].map(|scale| 1.0 / (scale * scale));
        self.hessian.fill(0.0);
        self.linear.fill(0.0);
        for i in 0..m {
            self.hessian[i * m + i] = 1.0 / (s.flow_g_s * s.flow_g_s);
        }
        // The state without any flow, and its slopes along each flow so far.
        let mut free = start;
        for (k, r) in references[..n].iter().enumerate() {
            let Step { a, b, c } = self.steps[k];
            free = affine(&a, free, c);
            for column in &mut self.columns[..k] {
                *column = [0, 1, 2, 3]
                    .map(|r| [0, 1].map(|i| (0..4).map(|j| a[r][j] * column[j][i]).sum()));
            }
            self.columns[k] = b;
            let misses = [
                free[0] - r.displacement_mm,
                free[1] - r.velocity_mm_s,
                free[2] + free[3] - r.total_g,
            ];
            for p in 0..2 * (k + 1) {
                let of_p = outputs(&self.columns[p / 2], p % 2);
                for o in 0..3 {
                    self.linear[p] += weights[o] * of_p[o] * misses[o];
                }
                for q in 0..=p {
                    let of_q = outputs(&self.columns[q / 2], q % 2);
                    let sum: f64 = (0..3).map(|o| weights[o] * of_p[o] * of_q[o]).sum();
                    self.hessian[p * m + q] += sum;
                }
            }
        }
        for p in 0..m {
            for q in 0..p {
                self.hessian[q * m + p] = self.hessian[p * m + q];
            }
        }
    }

    fn predict(&mut self, start: State) {
        let mut s = start;
        for k in 0..self.settings.steps {
            let Step { a, b, c } = self.steps[k];
            let mut next = affine(&a, s, c);
            for r in 0..4 {
                next[r] += b[r][0] * self.flows[2 * k] + b[r][1] * self.flows[2 * k + 1];
            }
            s = next;
            self.predicted[k + 1] = s;
        }
    }
}

/// Displacement, velocity and total air of a column.
fn outputs(column: &[[f64; 2]; 4], i: usize) -> [f64; 3] {
    [column[0][i], column[1][i], column[2][i] + column[3][i]]
}

fn affine(a: &Matrix, s: State, c: State) -> State {
    [0, 1, 2, 3].map(|r| c[r] + (0..4).map(|j| a[r][j] * s[j]).sum::<f64>())
}

/// `s⁺ = e^{aT} s + ∫₀ᵀ e^{aτ} dτ (g u + c)` by its series; `g` lets the flows into the masses.
fn discretise(a: &Matrix, c: State, step_s: f64) -> Step {
    let identity: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|j| f64::from(u8::from(r == j))));
    let (mut exponential, mut integral, mut term) = (identity, identity, identity);

    for n in 1..=7 {
        // term = (a T)ⁿ / n!
        let mut next = [[0.0; 4]; 4];
        for r in 0..4 {
            for j in 0..4 {
                next[r][j] =
                    (0..4).map(|k| term[r][k] * a[k][j]).sum::<f64>() * step_s / f64::from(n);
            }
        }
        term = next;
        let factor = f64::from(n + 1);
        for r in 0..4 {
            for j in 0..4 {
                exponential[r][j] += term[r][j];
                integral[r][j] += term[r][j] / factor;
            }
        }
    }
    let integral = integral.map(|row| row.map(|v| v * step_s));
    Step {
        a: exponential,
        b: [0, 1, 2, 3].map(|r| [integral[r][2], integral[r][3]]),
        c: affine(&integral, c, [0.0; 4]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of the linear joint against a hundred thousand small ones.
    #[test]
    fn a_step_is_the_solution_of_the_equations() {
        let a = [[0.0, 1.0, 0.0, 0.0], [-490.0, -21.0, 15e3, -14e3], [0.0; 4], [0.0; 4]];
        let (c, u) = ([0.0, 30.0, 0.0, 0.0], [0.1, -0.05]);
        let step = discretise(&a, c, 0.01);
        let mut s = [0.3, -1.0, 0.06, 0.07];
        let mut exact = affine(&step.a, s, step.c);
        (0..4).for_each(|r| exact[r] += step.b[r][0] * u[0] + step.b[r][1] * u[1]);
        let parts = 100_000;
        let h = 0.01 / f64::from(parts);
        for _ in 0..parts {
            let rate = |s: State| {
                let mut d = affine(&a, s, c);
                d[2] += u[0];
                d[3] += u[1];
                d
            };
            let half = rate(s);
            let middle: State = std::array::from_fn(|i| s[i] + 0.5 * h * half[i]);
            let d = rate(middle);
            (0..4).for_each(|i| s[i] += h * d[i]);
        }
        for i in 0..4 {
            assert!((s[i] - exact[i]).abs() < 1e-9 * (1.0 + s[i].abs()), "{s:?} {exact:?}");
        }
    }
}
