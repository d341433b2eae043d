//! Dynamic consistency and stiffness estimate as functions of the two air masses.

use super::batch::{ForceBatch, Point};
use super::problem::{SynthesisSettings, Target};
use pam_core::units::MN_PER_N;

/// Displacements at which the force is needed, in steps h from x: the first for the dynamics, the
/// others for `K̂ = [f(x+2h) + f(x+h) − f(x−h) − f(x−2h)] / 6h`.
pub(super) const OFFSETS: [f64; 5] = [0.0, 1.0, -1.0, 2.0, -2.0];
/// Signs of the forces in K̂.
pub(super) const SIGNS: [f64; 5] = [0.0, 1.0, -1.0, 1.0, -1.0];
/// Points of a stencil.
pub(super) const POINTS: usize = OFFSETS.len();

/// Values and derivatives at one pair of masses `u = (m_f, m_e)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Local {
    /// `g = m ẍ_d + f + B ẋ_d − F_e`, mN.
    pub(super) g: f64,
    /// K̂, N/mm.
    pub(super) k: f64,
    /// ∂g/∂u, mN/g.
    pub(super) dg: [f64; 2],
    /// ∂K̂/∂u, N/(mm·g).
    pub(super) dk: [f64; 2],
}

impl Local {
    /// Where nothing is known.
    pub(super) const UNKNOWN: Self =
        Self { g: f64::NAN, k: f64::NAN, dg: [f64::NAN; 2], dk: [f64::NAN; 2] };

    /// From forces and slopes at the points of the stencil; `inertial_mn` is `m ẍ_d + B ẋ_d − F_e`.
    pub(super) fn of(
        forces_mn: &[f64],
        slope: impl Fn(usize) -> [f64; 2],
        inertial_mn: f64,
        step_mm: f64,
    ) -> Self {
        let scale = 1.0 / (6.0 * step_mm * MN_PER_N);
        let mut local = Self { g: inertial_mn + forces_mn[0], dg: slope(0), ..Self::default() };
        for p in 1..POINTS {
            let [by_f, by_e] = slope(p);
            local.k += SIGNS[p] * scale * forces_mn[p];
            local.dk[0] += SIGNS[p] * scale * by_f;
            local.dk[1] += SIGNS[p] * scale * by_e;
        }
        local
    }
}

/// Mass and damping of the joint outside the force model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inertia {
    pub(super) mass_kg: f64,
    pub(super) damping_kg_s: f64,
}

impl Inertia {
    /// `m ẍ_d + B ẋ_d − F_e`, mN.
    pub(super) fn force_mn(&self, target: &Target) -> f64 {
        self.mass_kg * target.acceleration_mm_s2 + self.damping_kg_s * target.velocity_mm_s
            - target.load_mn
    }
}

/// Evaluates stencils, several targets at once.
pub(super) struct Evaluator<'a, B: ForceBatch> {
    batch: &'a B,
    inertia: Inertia,
    step_mm: f64,
    points: Vec<Point>,
    forces_mn: Vec<f64>,
    slopes: Vec<Point>,
    work: B::Work,
}

impl<'a, B: ForceBatch> Evaluator<'a, B> {
    pub(super) fn new(
        batch: &'a B,
        inertia: Inertia,
        settings: &SynthesisSettings,
        pairs: usize,
    ) -> Self {
        let capacity = pairs * POINTS;
        Self {
            batch,
            inertia,
            step_mm: settings.stiffness_step_mm,
            points: Vec::with_capacity(capacity),
            forces_mn: vec![0.0; capacity],
            slopes: vec![[0.0; 4]; capacity],
            work: batch.work(capacity),
        }
    }

    /// Writes what is known at the masses of each pair of target and masses.
    pub(super) fn evaluate<'t>(
        &mut self,
        pairs: impl Iterator<Item = (&'t Target, [f64; 2])> + Clone,
        out: &mut Vec<Local>,
    ) {
        self.points.clear();
        for (target, [m_f, m_e]) in pairs.clone() {
            for offset in OFFSETS {
                let x = target.displacement_mm + offset * self.step_mm;
                self.points.push([m_f, m_e, x, target.velocity_mm_s]);
            }
        }
        let n = self.points.len();
        let Self { batch, points, forces_mn, slopes, work, .. } = self;
        batch.slopes_into(points, &mut forces_mn[..n], &mut slopes[..n], work);
        out.clear();
        for (pair, (target, _)) in pairs.enumerate() {
            let at = pair * POINTS;
            let slope = |p: usize| [slopes[at + p][0], slopes[at + p][1]];
            let inertial = self.inertia.force_mn(target);
            out.push(Local::of(&forces_mn[at..at + POINTS], slope, inertial, self.step_mm));
        }
    }

    /// The same for one target.
    pub(super) fn at(&mut self, target: &Target, u: [f64; 2]) -> Local {
        let mut out = Vec::with_capacity(1);
        self.evaluate(std::iter::once((target, u)), &mut out);
        out[0]
    }

    /// `g` at many pairs of masses.
    pub(super) fn balances(&mut self, target: &Target, u: &[[f64; 2]], out: &mut Vec<f64>) {
        self.points.clear();
        let (x, v) = (target.displacement_mm, target.velocity_mm_s);
        self.points.extend(u.iter().map(|&[m_f, m_e]| [m_f, m_e, x, v]));
        out.clear();
        out.resize(u.len(), 0.0);
        self.batch.values_into(&self.points, out, &mut self.work);
        let inertial = self.inertia.force_mn(target);
        out.iter_mut().for_each(|g| *g += inertial);
    }
}
