//! The experiment that would tell confusable causes apart.
//!
//! For each candidate excitation the model is simulated with the named cause and, in its place, with each
//! alternative; what the alternative's own parameters could still make up for is taken away with its
//! sensitivities. What is left, in units of the error that counts as explained, is how well the excitation
//! separates the two. The excitation that separates the worst pair best for its length is chosen.

use crate::fit::{CHANNELS, Floors, Hypothesis, Problem};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_data::Subject;
use pam_data::{MassOrigin, Recording};
use pam_effects::effects::{AnyEffect, DataScales, Derivatives};
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::{Nuisances, ResampledRecord, Trajectory, Trial, simulate};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;
use std::path::Path;

/// A force on the joint, sinusoidal pieces one after another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excitation {
    /// What it is, in a few words.
    pub name: &'static str,
    /// Amplitude (N), frequency (Hz) and length (s) of each piece.
    pub pieces: Vec<[f64; 3]>,
}

/// How well an excitation separates the named cause from each alternative.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separation {
    /// The excitation.
    pub excitation: Excitation,
    /// Gauge pressures of flexor and extensor at which it is run, psi.
    pub psi: Vec<[f64; 2]>,
    /// Alternative and the difference that its own parameters cannot make up for: root mean square over all
    /// channels in units of what counts as explained.
    pub by_alternative: Vec<(String, f64)>,
}

impl Separation {
    /// The difference to the alternative that is hardest to tell apart.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.by_alternative.iter().map(|a| a.1).fold(f64::INFINITY, f64::min)
    }
}

/// Excitations that are tried, for a joint whose force reaches `force_n`.
#[must_use]
pub fn candidates(force_n: f64) -> Vec<Excitation> {
    let e = |name, pieces: &[[f64; 3]]| Excitation {
        name,
        pieces: pieces.iter().map(|p| [p[0] * force_n, p[1], p[2]]).collect(),
    };
    vec![
        e("slow and large", &[[1.0, 0.1, 30.0]]),
        e("slow, from small to large", &[[0.25, 0.2, 10.0], [0.5, 0.2, 10.0], [1.0, 0.2, 10.0]]),
        e("frequencies far apart", &[[0.8, 0.05, 20.0], [0.8, 0.5, 6.0], [0.8, 4.0, 4.0]]),
        e("fast", &[[1.0, 3.0, 15.0], [0.5, 5.0, 15.0]]),
        e("small, at several frequencies", &[[0.3, 0.2, 10.0], [0.3, 1.0, 10.0], [0.3, 3.0, 10.0]]),
        e("large, at several frequencies", &[[1.2, 0.2, 10.0], [1.2, 1.0, 10.0], [1.2, 2.0, 10.0]]),
    ]
}

/// Pairs of pressures that are tried: all of one level, and far apart.
const PRESSURES: [&[[f64; 2]]; 2] =
    [&[[45.0, 45.0], [30.0, 30.0]], &[[20.0, 20.0], [70.0, 70.0], [30.0, 70.0]]];

/// Tries excitations for the first of `named` against its alternatives, best separation first. `extended` is
/// the model with all named causes, of which `cause` is to be told from `alternatives`.
#[must_use]
pub fn separate(
    extended: &ExtendedModel,
    cause: &ActiveEffect,
    alternatives: &[ActiveEffect],
    scales: &DataScales,
    floors: &Floors,
) -> Vec<Separation> {
    let mut tried: Vec<(Excitation, &[[f64; 2]])> = Vec::new();
    for excitation in candidates(scales.force_n) {
        tried.extend(PRESSURES.iter().map(|p| (excitation.clone(), *p)));
    }
    let mut all: Vec<Separation> = tried
        .into_par_iter()
        .map(|(excitation, psi)| {
            let trials: Vec<Trial> =
                psi.iter().map(|&p| trial(extended, &excitation, p, scales)).collect();
            let by_alternative = alternatives
                .iter()
                .map(|a| {
                    let id = a.effect.info().id.to_owned();
                    (id, difference(extended, cause, a, &trials, floors).unwrap_or(0.0))
                })
                .collect();
            Separation { excitation, psi: psi.to_vec(), by_alternative }
        })
        .collect();
    all.sort_by(|a, b| b.least().total_cmp(&a.least()));
    all
}

/// A trial that nobody measured: the joint at rest under an excitation.
fn trial(
    model: &ExtendedModel,
    excitation: &Excitation,
    psi: [f64; 2],
    scales: &DataScales,
) -> Trial {
    let kpa = psi.map(|p| p * pam_core::units::KPA_PER_PSI + pam_core::units::ATMOSPHERE_KPA);
    let masses = model.joint.gas_law_masses(0.0, kpa);
    let length: f64 = excitation.pieces.iter().map(|p| p[2]).sum();
    let n = (length / ResampledRecord::STEP_S) as usize;
    let mut recording = Recording::empty(Path::new("design"));
    recording.time_s = (0..n).map(|k| k as f64 * ResampledRecord::STEP_S).collect();
    recording.force_mn = recording
        .time_s
        .iter()
        .map(|&t| {
            let mut from = 0.0;
            for [amplitude, frequency, duration] in &excitation.pieces {
                if t < from + duration {
                    return MN_PER_N * amplitude * (TAU * frequency * (t - from)).sin();
                }
                from += duration;
            }
            0.0
        })
        .collect();
    // The table must cover what the excitation may reach.
    let reach = |k: usize, size: f64| match k {
        0 => -size,
        1 => size,
        _ => 0.0,
    };
    recording.displacement_mm = (0..n).map(|k| reach(k, 2.0 * scales.travel_mm)).collect();
    recording.velocity_mm_s = (0..n).map(|k| reach(k, 2.0 * scales.speed_mm_s)).collect();
    recording.pressure_flexor_kpa = vec![kpa[0]; n];
    recording.pressure_extensor_kpa = vec![kpa[1]; n];
    let mut t =
        Trial::new(&model.joint, &Subject { recording, masses, origin: MassOrigin::GasLaw });
    (t.record.rest.start_mm, t.record.rest.sealed_mm, t.record.start_mm_s) = (0.0, 0.0, 0.0);
    t
}

/// Root mean square of what separates two causes, less what the alternative's parameters make up for.
fn difference(
    extended: &ExtendedModel,
    cause: &ActiveEffect,
    alternative: &ActiveEffect,
    trials: &[Trial],
    floors: &Floors,
) -> Option<f64> {
    let swapped = |with: &ActiveEffect| {
        let mut model = extended.clone();
        for active in &mut model.effects {
            if active.effect.info().id == cause.effect.info().id {
                *active = with.clone();
            }
        }
        model
    };
    let named = swapped(cause);
    let other = swapped(alternative);
    let place =
        other.effects.iter().position(|a| a.effect.info().id == alternative.effect.info().id)?;
    let base = extended.base();
    let problem = Problem::new(trials.iter(), base, 1.0, *floors);
    let parameters = alternative.effect.info().parameters.len();
    let mut rows: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); parameters];
    for (i, t) in trials.iter().enumerate() {
        let parts = named.parts();
        let fixed: Vec<(&dyn AnyEffect, Vec<f64>)> =
            parts.iter().map(|(e, v)| (*e as &dyn AnyEffect, v.clone())).collect();
        let mut truth = Trajectory::default();
        problem.simulate(&Hypothesis::base(&fixed, trials.len()), i, &mut truth).ok()?;
        let effects: Vec<&dyn AnyEffect> =
            other.effects.iter().map(|a| a.effect as &dyn AnyEffect).collect();
        let mut values: Vec<Derivatives> = Vec::new();
        for (k, active) in other.effects.iter().enumerate() {
            for (q, &v) in active.values.iter().enumerate() {
                let seeded = k == place && q < parameters;
                values.push(if seeded {
                    Derivatives::variable(v, q)
                } else {
                    Derivatives::constant(v)
                });
            }
        }
        let mut out = Trajectory::default();
        simulate(t, &base, &effects, &values, &Nuisances::none(), &mut out).ok()?;
        for (c, floor) in CHANNELS.into_iter().zip(floors.0) {
            for (a, b) in truth.channels[c].iter().zip(&out.channels[c]) {
                rows.push((a - b.value) / floor);
                for (q, column) in columns.iter_mut().enumerate() {
                    column.push(b.derivatives[q] / floor);
                }
            }
        }
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt().max(1e-12)).collect();
    let gram = Mat::from_fn(parameters, parameters, |i, j| {
        let ridge = if i == j { 1e-9 } else { 0.0 };
        dot(&columns[i], &columns[j]) / (size[i] * size[j]) + ridge
    });
    let right = Mat::from_fn(parameters, 1, |i, _| dot(&columns[i], &rows) / size[i]);
    let solved = gram.llt(Side::Lower).ok()?.solve(&right);
    for (i, column) in columns.iter().enumerate() {
        let step = solved[(i, 0)] / size[i];
        rows.iter_mut().zip(column).for_each(|(r, c)| *r -= step * c);
    }
    Some((dot(&rows, &rows) / rows.len() as f64).sqrt())
}
