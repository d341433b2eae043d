//! A plant of the studies: a joint with the published network force and everything that can be wrong with it.
//!
//! The equations are written out here once more and share no code with the simulation of the diagnosis
//! (`pam-effects`): an estimator that knows the code of its plant proves nothing. One file each:
//!
//! | file | content |
//! |---|---|
//! | `hidden` | an effect that is hidden: id, parameters, onset, recordings |
//! | `acting` | the effects that act at a moment, as plain numbers |
//! | `laws` | laws that stand in no list |
//! | `network` | the restoring force, evaluated by its linear regions |
//! | `excitation` | what the motor is told to do |
//! | `motion` | one step of the joint: set-valued dry friction, second order elsewhere |
//! | `sensing` | play, lags and delays between the joint and the recorded columns |
//! | `noise` | white and coloured noise, encoder steps, sampling rate |

mod acting;
mod excitation;
mod hidden;
mod laws;
mod motion;
mod network;
mod noise;
mod sensing;

pub use excitation::Excitation;
pub use hidden::Hidden;
pub(crate) use noise::normal;
pub use noise::{Colour, Noise, Sensors};

use acting::Acting;
use motion::Joint;
use network::ReluNetwork;
use noise::Source;
use pam_core::{AnyForce, JointModel, SealedMasses};
use pam_data::preprocess::refilter;
use pam_data::recording::{Recording, SealedReading};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sensing::Chain;
use std::path::Path;

/// Longest step of the integration, s: a quarter of a millisecond.
const LONGEST_STEP_S: f64 = 2.5e-4;

/// Longest rest before the excitation over which the sealed reading is averaged, s.
const REST_S: f64 = 0.5;

/// Most samples of that rest, as many as the published loader averages.
const REST_SAMPLES: usize = 100;

/// Fewest samples of it.
const FEWEST_REST_SAMPLES: usize = 10;

/// Pressure of the room, kPa; kPa per psi.
const ATMOSPHERE_KPA: f64 = 101.325;
const KPA_PER_PSI: f64 = 6.894_76;

/// The joint of a hybrid model with a network of two hidden layers, without any effect.
#[derive(Debug, Clone)]
pub struct Plant {
    network: ReluNetwork,
    mass_kg: f64,
    deformation: f64,
    gas_coefficient: f64,
}

/// A run of the plant.
#[derive(Debug, Clone, Copy)]
pub struct Experiment<'a> {
    /// Name of the recording.
    pub name: &'a str,
    /// Gauge pressures at rest of flexor and extensor, psi.
    pub psi: [f64; 2],
    /// Commanded force.
    pub excitation: &'a Excitation,
    /// What is hidden.
    pub effects: &'a [Hidden],
    /// Rate, steps and noise of the sensors.
    pub sensors: &'a Sensors,
    /// Seed of the noise.
    pub seed: u64,
    /// Longest step of the integration, s.
    pub longest_step_s: f64,
}

impl<'a> Experiment<'a> {
    /// A run with steps of at most a quarter of a millisecond.
    #[must_use]
    pub fn new(
        name: &'a str,
        psi: [f64; 2],
        excitation: &'a Excitation,
        effects: &'a [Hidden],
        sensors: &'a Sensors,
        seed: u64,
    ) -> Self {
        Self { name, psi, excitation, effects, sensors, seed, longest_step_s: LONGEST_STEP_S }
    }
}

impl Plant {
    /// The plant that is exactly this model.
    ///
    /// # Panics
    /// If its force is not a leaky ReLU network with two hidden layers.
    #[must_use]
    pub fn of(model: &JointModel<f64, AnyForce<f64>>) -> Self {
        let p = model.physical();
        Self {
            network: ReluNetwork::of(&model.force),
            mass_kg: p.mass_kg,
            deformation: p.deformation,
            gas_coefficient: p.gas_coefficient,
        }
    }

    /// The plant with another moving mass.
    #[must_use]
    pub fn with_mass(&self, factor: f64) -> Self {
        Self { mass_kg: factor * self.mass_kg, ..self.clone() }
    }

    /// The plant with another deformation coefficient.
    #[must_use]
    pub fn with_deformation(&self, factor: f64) -> Self {
        Self { deformation: factor * self.deformation, ..self.clone() }
    }

    /// Samples of the rest before the excitation over which the sealed reading is averaged.
    #[must_use]
    pub fn rest_samples(rate_hz: f64) -> usize {
        ((REST_S * rate_hz) as usize).clamp(FEWEST_REST_SAMPLES, REST_SAMPLES)
    }

    /// Records a run: sampled columns, filtered as the sensors say, with the sealed reading before the excitation.
    ///
    /// # Panics
    /// If the recording cannot be filtered.
    #[must_use]
    pub fn record(&self, run: &Experiment<'_>) -> Recording {
        let sensors = run.sensors;
        let rate = sensors.rate_hz;
        let steps = (1.0 / (rate * run.longest_step_s)).ceil().max(1.0) as usize;
        let dt = 1.0 / (rate * steps as f64);
        let kpa = run.psi.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA);
        let mut acting = Acting::at(run.effects, 0.0);
        let mut changes = acting::changes(run.effects).into_iter().peekable();
        let mut joint = Joint::at_rest(self, kpa, &acting);
        let mut chain = Chain::new(&joint, &acting, run.effects, dt);
        let mut random = ChaCha8Rng::seed_from_u64(run.seed);
        let mut noise = [
            Source::new(sensors.displacement, rate, &mut random),
            Source::new(sensors.pressure, rate, &mut random),
            Source::new(sensors.pressure, rate, &mut random),
            Source::new(sensors.force, rate, &mut random),
        ];
        let rest = Self::rest_samples(rate);
        // From zero to the end, both included.
        let samples = (run.excitation.duration_s() * rate).round() as usize + 1;
        let mut recording = Recording::empty(Path::new(run.name));
        let mut sealed = [0.0; 3];
        for k in 0..rest + samples {
            let t = (k as f64 - rest as f64) / rate;
            while let Some(change) = changes.next_if(|&c| t >= c - 1e-9) {
                acting = Acting::at(run.effects, t);
                joint.masses_g[0] += acting::injected_g(run.effects, change);
            }
            let read = chain.read(&acting, t);
            let x = sensors.quantised(read[0] + noise[0].next(&mut random));
            let p = [1, 2].map(|i| read[i] + noise[i].next(&mut random));
            let force_noise = noise[3].next(&mut random);
            if k < rest {
                for (sum, value) in sealed.iter_mut().zip([x, p[0], p[1]]) {
                    *sum += value / rest as f64;
                }
            } else {
                recording.time_s.push(t);
                recording.displacement_mm.push(x);
                recording.pressure_flexor_kpa.push(p[0]);
                recording.pressure_extensor_kpa.push(p[1]);
                recording.force_mn.push(1e3 * (run.excitation.force_n(t) + force_noise));
            }
            for step in 0..steps {
                let middle = t + (step as f64 + 0.5) * dt;
                let begin = t + step as f64 * dt - acting.actuation_delay_s;
                let given = |at: f64| if at < 0.0 { 0.0 } else { run.excitation.force_n(at) };
                let command = if sensors.smooth_force {
                    given(begin + 0.5 * dt)
                } else {
                    // A held command keeps the value of the last sample; in the middle of a step it may take the next.
                    let last = (begin * rate + 1e-9).floor();
                    let before = ((last + 1.0) / rate - begin).clamp(0.0, dt) / dt;
                    before * given(last / rate) + (1.0 - before) * given((last + 1.0) / rate)
                };
                joint.step(1e3 * command, middle, &acting, dt);
                chain.step(&joint, &acting, dt);
            }
        }
        recording.velocity_mm_s = vec![0.0; recording.time_s.len()];
        recording.sealed = Some(SealedReading {
            displacement_mm: sealed[0],
            pressure_flexor_kpa: sealed[1],
            pressure_extensor_kpa: sealed[2],
        });
        refilter(recording, sensors.cutoff_hz).expect("long enough to filter")
    }
}

/// The masses by the model's gas law at the sealed reading.
#[must_use]
pub fn masses(model: &JointModel<f64, AnyForce<f64>>, recording: &Recording) -> SealedMasses {
    let rest = recording.reading_at_rest();
    model.gas_law_masses(
        rest.displacement_mm,
        [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa],
    )
}
