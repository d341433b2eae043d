//! A trajectory with its air and its pressure commands.

use super::certified::CertifiedSynthesiser;
use super::problem::{MassBounds, Outcome, Solution, SynthesisSettings, Target};
use super::solver::Synthesiser;
use crate::error::ControlError;
use crate::motion::{MotionSpec, StiffnessProfile};
use pam_core::units::MN_PER_N;
use pam_core::{AnyForce, JointModel};
use pam_exact::Certificate;
use serde::Serialize;

/// Samples of a motion, as targets for the synthesis.
///
/// A stiffness or load column of the motion's file goes before `stiffness` and `load_n`.
///
/// # Errors
/// [`ControlError`] if the rate is impossible, or there is neither a stiffness nor a column of it.
pub fn targets(
    spec: &MotionSpec,
    stiffness: Option<&StiffnessProfile>,
    load_n: f64,
    rate_hz: f64,
) -> Result<Vec<Target>, ControlError> {
    ControlError::require_positive("rate (Hz)", rate_hz)?;
    ControlError::require_finite("load (N)", load_n)?;
    let count = spec.duration_s * rate_hz;
    if !(1.0..1e8).contains(&count) {
        return Err(ControlError::Value {
            field: "rate (Hz)",
            value: rate_hz,
            why: format!("{} s at this rate are no trajectory", spec.duration_s),
        });
    }
    let column = spec.table.as_ref();
    (0..=count.round() as usize)
        .map(|k| {
            let time_s = k as f64 / rate_hz;
            let point = spec.motion.at(time_s);
            let stiffness_n_mm = column
                .and_then(|t| t.stiffness_n_mm(time_s))
                .or_else(|| stiffness.map(|s| s.at(time_s)))
                .ok_or_else(|| {
                    ControlError::Insufficient(
                        "no stiffness is given: add a column `stiffness_n_mm` or a profile".into(),
                    )
                })?;
            let load = column.and_then(|t| t.force_n(time_s)).unwrap_or(load_n);
            Ok(Target {
                time_s,
                displacement_mm: point.displacement_mm,
                velocity_mm_s: point.velocity_mm_s,
                acceleration_mm_s2: point.acceleration_mm_s2,
                stiffness_n_mm,
                load_mn: load * MN_PER_N,
            })
        })
        .collect()
}

/// By which share of the width of the mass bounds the air may differ between the ends of a period: with the trained bounds
/// 0.05 kPa.
const LARGEST_JUMP: f64 = 1e-4;

/// A planned trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The targets.
    pub targets: Vec<Target>,
    /// The air.
    pub solutions: Vec<Solution>,
    /// Pressures of flexor and extensor that hold this air at the wanted displacement,
    /// `P_i = C m_i / V_i(x_d)`, kPa absolute.
    pub pressures_kpa: Vec<[f64; 2]>,
    /// Between which masses the model was trained.
    pub trained: MassBounds,
}

impl Plan {
    /// Plans a trajectory. Samples whose stiffness cannot be reached hold the nearest one and say so.
    ///
    /// # Errors
    /// [`ControlError::Motion`] if the motion of a sample cannot be reached at all, [`ControlError::Value`] for
    /// impossible settings or targets.
    pub fn new(
        model: &JointModel<f64, AnyForce<f64>>,
        targets: Vec<Target>,
        settings: SynthesisSettings,
    ) -> Result<Self, ControlError> {
        let solutions = Synthesiser::new(model, settings)?.solve(&targets)?;
        Self::of_solutions(model, targets, solutions)
    }

    /// As [`new`](Self::new) for targets that repeat after `period` samples: one period is planned, and the others hold the
    /// same air. Where that would make the air jump, because the branch of solutions at the end of the period is not that at
    /// its beginning, all samples are planned.
    ///
    /// Only the times of the targets are read beyond the first period.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn periodic(
        model: &JointModel<f64, AnyForce<f64>>,
        targets: Vec<Target>,
        period: usize,
        settings: SynthesisSettings,
    ) -> Result<Self, ControlError> {
        if period == 0 || targets.len() <= period + 1 {
            return Self::new(model, targets, settings);
        }
        let solutions = Synthesiser::new(model, settings)?.solve(&targets[..=period])?;
        let [begin, end] = [0, period].map(|k| solutions[k].masses);
        let jump_g = (begin.flexor_g - end.flexor_g).hypot(begin.extensor_g - end.extensor_g);
        if jump_g > LARGEST_JUMP * settings.bounds.width_g() {
            return Self::new(model, targets, settings);
        }
        let count = targets.len();
        let repeated = |k: usize| (targets[k % period], solutions[k % period]);
        let (mut again, solutions): (Vec<Target>, Vec<Solution>) = (0..count).map(repeated).unzip();
        for (to, from) in again.iter_mut().zip(&targets) {
            to.time_s = from.time_s;
        }
        Self::of_solutions(model, again, solutions)
    }

    /// As [`new`](Self::new), every sample the global optimum, with its certificate; for (leaky)
    /// ReLU networks.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`ControlError::Insufficient`] for another force.
    pub fn certified(
        model: &JointModel<f64, AnyForce<f64>>,
        targets: Vec<Target>,
        settings: SynthesisSettings,
    ) -> Result<(Self, Vec<Certificate>), ControlError> {
        let solved = CertifiedSynthesiser::new(model, settings)?.solve(&targets)?;
        let (solutions, certificates) = solved.into_iter().unzip();
        Ok((Self::of_solutions(model, targets, solutions)?, certificates))
    }

    /// Adds pressures to solutions; a motion that cannot be had is an error.
    fn of_solutions(
        model: &JointModel<f64, AnyForce<f64>>,
        targets: Vec<Target>,
        solutions: Vec<Solution>,
    ) -> Result<Self, ControlError> {
        let mut missed = targets
            .iter()
            .zip(&solutions)
            .filter(|(_, s)| s.outcome == Outcome::MotionUnreachable)
            .peekable();
        if let Some((t, s)) = missed.peek().copied() {
            return Err(ControlError::Motion {
                time_s: t.time_s,
                displacement_mm: t.displacement_mm,
                velocity_mm_s: t.velocity_mm_s,
                acceleration_mm_s2: t.acceleration_mm_s2,
                missing_n: s.residual_mn.abs() / MN_PER_N,
                count: missed.count(),
                samples: targets.len(),
            });
        }
        let pressures_kpa = targets
            .iter()
            .zip(&solutions)
            .map(|(t, s)| model.gas_law_pressures_kpa(t.displacement_mm, s.masses))
            .collect();
        Ok(Self { trained: MassBounds::trained(model), targets, solutions, pressures_kpa })
    }

    /// True if the air of a sample lies outside the training range of the model.
    #[must_use]
    pub fn extrapolates(&self, sample: usize) -> bool {
        !self.trained.contain(self.solutions[sample].masses)
    }

    /// The plan in a few numbers.
    #[must_use]
    pub fn summary(&self) -> PlanSummary {
        let missed = || self.solutions.iter().filter(|s| s.outcome == Outcome::NearestStiffness);
        let miss = |(t, s): (&Target, &Solution)| (s.stiffness_n_mm - t.stiffness_n_mm).abs();
        let fold = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)])
        };
        PlanSummary {
            samples: self.targets.len(),
            reached: self.targets.len() - missed().count(),
            nearest_stiffness: missed().count(),
            largest_residual_mn: self.solutions.iter().fold(0.0, |m, s| m.max(s.residual_mn.abs())),
            largest_stiffness_error_n_mm: self
                .targets
                .iter()
                .zip(&self.solutions)
                .map(miss)
                .fold(0.0, f64::max),
            stiffness_n_mm: fold(&mut self.solutions.iter().map(|s| s.stiffness_n_mm)),
            mass_g: fold(
                &mut self.solutions.iter().flat_map(|s| [s.masses.flexor_g, s.masses.extensor_g]),
            ),
            pressure_kpa: fold(&mut self.pressures_kpa.iter().flatten().copied()),
            extrapolated: (0..self.targets.len()).filter(|&k| self.extrapolates(k)).count(),
        }
    }
}

/// A plan in a few numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanSummary {
    /// Number of samples.
    pub samples: usize,
    /// Samples whose motion and stiffness are met.
    pub reached: usize,
    /// Samples that hold the nearest stiffness instead.
    pub nearest_stiffness: usize,
    /// Largest |m ẍ_d + f + B ẋ_d − F_e|, mN.
    pub largest_residual_mn: f64,
    /// Largest |K̂ − K_d|, N/mm.
    pub largest_stiffness_error_n_mm: f64,
    /// Least and largest K̂, N/mm.
    pub stiffness_n_mm: [f64; 2],
    /// Least and most air in a muscle, g.
    pub mass_g: [f64; 2],
    /// Least and largest pressure, kPa absolute.
    pub pressure_kpa: [f64; 2],
    /// Samples whose air lies outside what the model was trained on.
    pub extrapolated: usize,
}
