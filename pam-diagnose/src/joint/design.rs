//! Force excitations that would distinguish confusable causes of the joint.

use super::system::JointSystem;
use crate::data::OpenPart;
use crate::design::difference;
use crate::fit::{Hypothesis, Member};
use crate::settings::DiagnosisSettings;
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_data::Subject;
use pam_data::{MassOrigin, Recording};
use pam_effects::effects::{AnyEffect, DataScales};
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::{ResampledRecord, StartVelocity, Trial};
use serde::Serialize;
use std::f64::consts::TAU;
use std::path::Path;

/// A force on the joint, sinusoidal pieces one after another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excitation {
    /// Short description.
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
    /// channels in units of the noise.
    pub by_alternative: Vec<(String, f64)>,
}

impl Separation {
    /// The difference to the alternative that is hardest to distinguish.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.by_alternative.iter().map(|a| a.1).fold(f64::INFINITY, f64::min)
    }
}

/// Excitations that are tried, for a joint whose force reaches `force_n`.
#[must_use]
pub fn excitations(force_n: f64) -> Vec<Excitation> {
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

/// Tries excitations, best separation first. `extended` is the model with all named causes, of which the one at `place`
/// is to be distinguished from `alternatives`; `noise` is the standard deviation of x, P_f and P_e.
#[must_use]
pub fn separate(
    extended: &ExtendedModel,
    place: usize,
    alternatives: &[ActiveEffect],
    scales: &DataScales,
    noise: &[f64],
) -> Vec<Separation> {
    let mut settings = DiagnosisSettings::default();
    settings.data.points_per_row = 1;
    // The effects of the model, then the alternatives.
    let actives: Vec<&ActiveEffect> = extended.effects.iter().chain(alternatives).collect();
    let member = |candidate: usize| Member::always(candidate, &actives[candidate].values);
    let mut tried: Vec<(Excitation, &[[f64; 2]])> = Vec::new();
    for excitation in excitations(scales.force_n) {
        tried.extend(PRESSURES.iter().map(|p| (excitation.clone(), *p)));
    }
    let mut all: Vec<Separation> = parallel::map_each(tried, |(excitation, psi)| {
        let trials: Vec<Trial> =
            psi.iter().map(|&p| trial(extended, &excitation, p, scales)).collect();
        let all = OpenPart::whole(trials.len());
        let effects: Vec<&'static dyn AnyEffect> = actives.iter().map(|a| a.effect).collect();
        let (of_trials, base) = (trials.iter().collect(), extended.base());
        let system = JointSystem::new(of_trials, &all, base, &[], effects, &settings);
        let named = Hypothesis {
            members: (0..extended.effects.len()).map(member).collect(),
            ..Hypothesis::base(&system, trials.len())
        };
        let by_alternative = (extended.effects.len()..actives.len())
            .map(|alternative| {
                let mut other = named.clone();
                other.members[place] = member(alternative);
                let distance = difference(&system, &named, &other, place, noise);
                (actives[alternative].effect.info().id.to_owned(), distance.unwrap_or(0.0))
            })
            .collect();
        Separation { excitation, psi: psi.to_vec(), by_alternative }
    });
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
    (t.record.rest.start_mm, t.record.rest.sealed_mm) = (0.0, 0.0);
    t.record.start_velocity = StartVelocity { mm_s: 0.0, deviation_mm_s: 0.0 };
    t
}
