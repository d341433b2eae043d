//! The baseline discrepancy of the joint.

use super::diagnose::{DiagnoseOptions, ready_trials};
use super::spans::spans;
use super::system::JointSystem;
use crate::data::{Roles, TestSource};
use crate::diagnosis::Baseline;
use crate::error::DiagnoseError;
use crate::fit::{Member, Problem};
use crate::noise::{Discrepancy, Noise};
use crate::search::Candidates;
use crate::settings::DiagnosisSettings;
use pam_data::Subject;
use pam_effects::effects::{ALL, AnyEffect};
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::Trial;
use serde::Serialize;

/// Effects and error level of baseline recordings. A model that misses something small everywhere misses it
/// in the data under diagnosis as well; that counts as no fault.
#[derive(Debug, Clone, Serialize)]
pub struct BaselineDiscrepancy {
    /// Effects that the baseline recordings show; part of the model from there on.
    pub effects: Vec<ActiveEffect>,
    /// The share of each effect that the data under diagnosis have, from 0 to 1.
    pub shares: Vec<f64>,
    /// Prior standard deviations of these shares.
    pub share_deviations: Vec<f64>,
    /// Root-mean-square errors that are left then: mm, kPa, kPa.
    pub rms: Vec<f64>,
    /// By how much the prior standard deviations of start (mm), start (mm/s), flexor and extensor mass, flexor and extensor
    /// offset have to be wider for the baseline recordings, and are in the data under diagnosis.
    pub local_widenings: Vec<f64>,
    /// Names of the baseline recordings.
    pub recordings: Vec<String>,
    /// The errors that go with the motion.
    #[serde(skip)]
    pub(super) discrepancy: Discrepancy,
    #[serde(skip)]
    noise: Noise,
}

impl BaselineDiscrepancy {
    /// Learns the discrepancy from baseline recordings, with the settings, the seed and the noise of the options. Diagnoses
    /// with the same model and baseline recordings may share it
    /// ([`DiagnoseOptions::discrepancy`]).
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings are too short or the model diverges on them.
    pub fn learn(
        model: &ExtendedModel,
        recordings: &[Subject],
        options: &DiagnoseOptions,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, DiagnoseError> {
        let subjects: Vec<&Subject> = recordings.iter().collect();
        let trials = ready_trials(model, &subjects, &options.settings)?;
        Self::from_trials(model, &trials, options, done)
    }

    /// As [`learn`](Self::learn), from recordings that are ready for simulation.
    pub(super) fn from_trials(
        model: &ExtendedModel,
        trials: &[Trial],
        options: &DiagnoseOptions,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, DiagnoseError> {
        let (settings, seed) = (&options.settings, options.seed);
        let roles = Roles::assign(
            &spans(&trials.iter().collect::<Vec<_>>()),
            TestSource::Kept,
            &settings.data,
        )?;
        // Effects of the vocabulary only: a candidate of the user's is what is asked about.
        let effects: Vec<&'static dyn AnyEffect> = ALL.to_vec();
        let all: Vec<&Trial> = trials.iter().collect();
        let (base, open) = (model.base(), roles.open());
        let system = JointSystem::new(all, &open, base, &model.effects, effects, settings);
        let (noise, prior) = system.first_noise(&open, options.noise);
        let found = Baseline::learn(&system, &roles, &noise, prior, settings, seed, done)?;
        let active = |m: Member| ActiveEffect { effect: ALL[m.candidate], values: m.values };
        let least = settings.fit.share_deviation;
        let deviation = |d: &f64| d.clamp(least, 1.0);
        Ok(Self {
            effects: found.members.into_iter().map(active).collect(),
            shares: vec![1.0; found.deviations.len()],
            share_deviations: found.deviations.iter().map(deviation).collect(),
            rms: found.rms,
            local_widenings: found.local_widenings,
            recordings: found.recordings,
            discrepancy: found.discrepancy,
            noise: found.noise,
        })
    }

    /// Root mean squares of the errors that go with the motion.
    pub(super) fn sizes(&self) -> Vec<f64> {
        self.discrepancy.covariances.deviations()
    }

    /// The baseline recordings as a problem: what a candidate seems to be where it is absent.
    pub(super) fn problem<'a>(
        &self,
        system: &'a JointSystem<'a>,
        settings: &'a DiagnosisSettings,
    ) -> Result<Problem<'a, dyn Candidates + 'a>, DiagnoseError> {
        let roles = Roles::assign(&spans(&system.trials), TestSource::Absent, &settings.data)?;
        let system: &dyn Candidates = system;
        Ok(roles.whole(system, &self.noise, settings))
    }
}
