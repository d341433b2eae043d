//! A linear joint, whose answers have closed forms, and runs of it.

use super::complex::Complex;
use pam_core::{AnyForce, JointModel, SealedMasses, SpringDamper};
use pam_data::Subject;
use pam_data::{MassOrigin, Recording};
use pam_effects::effects::{AnyEffect, by_id};
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
use std::f64::consts::PI;

/// Stiffness, mN/mm.
pub(crate) const K: f64 = 150e3;
/// Damping, mN·s/mm.
pub(crate) const B: f64 = 6500.0;
/// Mass, kg, of the datasheet.
pub(crate) const M: f64 = 253.9;
/// Sealed pressure, kPa absolute.
pub(crate) const P: f64 = 412.0;
/// Sampling of the made-up recordings, s.
pub(crate) const DT: f64 = 1e-3;
/// A recorded force is held for a sample, so it acts half a sample late on average, s.
pub(crate) const HOLD: f64 = 0.5 * DT;
/// Free motion has died out by a factor of 1e-16 after this time, s.
pub(crate) const SETTLED_S: f64 = 3.0;

pub(crate) type Joint = JointModel<f64, AnyForce<f64>>;

pub(crate) fn linear() -> Joint {
    JointModel::datasheet(AnyForce::from(SpringDamper::constant(K, B)))
}

/// The joint without damping.
pub(crate) fn undamped() -> Joint {
    JointModel::datasheet(AnyForce::from(SpringDamper::constant(K, 0.0)))
}

/// A recording of a force (N) alone: everything else stands still at `x` (mm) and 412 kPa.
pub(crate) fn driven(duration_s: f64, x: f64, force_n: impl Fn(f64) -> f64) -> Recording {
    let count = (duration_s / DT).round() as usize + 1;
    let time_s: Vec<f64> = (0..count).map(|k| k as f64 * DT).collect();
    Recording {
        displacement_mm: vec![x; count],
        velocity_mm_s: vec![0.0; count],
        pressure_flexor_kpa: vec![P; count],
        pressure_extensor_kpa: vec![P; count],
        force_mn: time_s.iter().map(|&t| 1e3 * force_n(t)).collect(),
        time_s,
        ..Recording::empty("made_up")
    }
}

/// Masses of `P` at rest at `x`, given or by the gas law.
pub(crate) fn subject(model: &Joint, recording: Recording, origin: MassOrigin) -> Subject {
    let masses: SealedMasses = model.gas_law_masses(recording.displacement_mm[0], [P, P]);
    Subject { recording, masses, origin }
}

/// A run with effects, by id and values, on the simulation's grid.
pub(crate) struct Run {
    pub(crate) step_s: f64,
    pub(crate) x: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) p: [Vec<f64>; 2],
}

impl Run {
    pub(crate) fn time_s(&self, k: usize) -> f64 {
        self.step_s * k as f64
    }

    /// Grid points after the free motion has died out.
    pub(crate) fn settled(&self) -> std::ops::Range<usize> {
        (SETTLED_S / self.step_s) as usize..self.x.len()
    }

    /// Largest distance of the settled displacement from a function of time.
    pub(crate) fn distance(&self, expected: impl Fn(f64) -> f64) -> f64 {
        let worst = |k: usize| (self.x[k] - expected(self.time_s(k))).abs();
        self.settled().map(worst).fold(0.0, f64::max)
    }
}

pub(crate) fn run(model: &Joint, subject: &Subject, effects: &[(&str, &[f64])]) -> Run {
    let trial = Trial::new(model, subject);
    let parts: Vec<&dyn AnyEffect> = effects
        .iter()
        .map(|(id, _)| by_id(id).expect("an id of the vocabulary") as &dyn AnyEffect)
        .collect();
    let values: Vec<f64> = effects.iter().flat_map(|(_, v)| v.iter().copied()).collect();
    let mut out = Trajectory::default();
    simulate::<f64>(&trial, &Base::of(model), &parts, &values, &Nuisances::none(), &mut out)
        .expect("the run stays in range");
    let [x, v, pf, pe] = out.channels;
    Run { step_s: trial.record.step_s, x, v, p: [pf, pe] }
}

/// A run of the linear joint from rest at `x`, with given masses.
pub(crate) fn linear_run(
    duration_s: f64,
    x: f64,
    force_n: impl Fn(f64) -> f64,
    effects: &[(&str, &[f64])],
) -> Run {
    let model = linear();
    let subject = subject(&model, driven(duration_s, x, force_n), MassOrigin::Given);
    run(&model, &subject, effects)
}

/// Amplitude of x (mm) for a force of 1 N with angular rate ω: `1000/(K − m ω² + j ω B)`.
pub(crate) fn answer(stiffness: Complex, damping: f64, mass: f64, rate: f64) -> Complex {
    let dynamic = stiffness + Complex(-mass * rate * rate, rate * damping);
    Complex::real(1e3) / dynamic
}

/// The same of the joint as it is.
pub(crate) fn plain(rate: f64) -> Complex {
    answer(Complex::real(K), B, M, rate)
}

/// Chamber volumes (mm³) of flexor and extensor, and their slopes (mm²), of a muscle with r0 = 5 mm and
/// L0 = 200 mm: `V = π r² (L0 ∓ x)` with `r = r0 ± ν (r0/L0) x`.
pub(crate) fn volumes(x: f64, nu: f64) -> ([f64; 2], [f64; 2]) {
    let one = |s: f64| {
        let (r, l) = (5.0 + s * nu * 5.0 / 200.0 * x, 200.0 - s * x);
        (PI * r * r * l, s * PI * (2.0 * r * l * nu * 5.0 / 200.0 - r * r))
    };
    let (f, e) = (one(1.0), one(-1.0));
    ([f.0, e.0], [f.1, e.1])
}
