//! Recordings of the joint as experiments, effects as candidates.

use super::baseline::BaselineDiscrepancy;
use super::divergence::diverges;
use super::motions::{self, Motions};
use super::parts::{Parts, in_part};
use super::scales::data_scales;
use super::sensitivities::Experiment;
use super::start::StartDeviations;
use super::{factors, features};
use crate::data::OpenPart;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Sensitivities};
use crate::noise::{NoisePrior, estimated_noise, moving_discrepancy};
use crate::onset::{Acts, Pattern};
use crate::search::{CandidateInfo, Candidates, Nuisance, OutputInfo};
use crate::settings::DiagnosisSettings;
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};
use pam_data::Channel;
use pam_effects::effects::{AnyEffect, DataScales, EffectScalar, FixedState, timed};
use pam_effects::model::ActiveEffect;
use pam_effects::simulation::{
    Base, Nuisances, ResampledRecord, Trajectory, Trial, needed_substeps, simulate_until,
};
use std::ops::Range;

/// Recordings of a joint, its model, and effects that may be missing from it.
pub struct JointSystem<'a> {
    pub(super) trials: Vec<&'a Trial>,
    pub(super) base: Base<f64>,
    /// Effects that are part of the model.
    pub(super) fixed: Vec<ActiveEffect>,
    /// Effects that baseline recordings have shown, of which the data may have a part only.
    pub(super) learned: Vec<ActiveEffect>,
    pub(super) effects: Vec<&'static dyn AnyEffect>,
    /// Candidates behind the effects, with the standard deviations of the priors of their parameters.
    pub(super) terms: Vec<(&'a dyn AnyEffect, Vec<f64>)>,
    pub(super) scales: DataScales,
    shared: Vec<Nuisance>,
    local: [Nuisance; 6],
    outputs: [OutputInfo; 4],
    settings: DiagnosisSettings,
    /// Grid points of each trial that are simulated where only its open part is asked for.
    open_points: Vec<usize>,
    /// Integration steps from one grid point of each trial to the next, without effects.
    steps_per_point: Vec<usize>,
    /// The most recently used motions, trial by trial.
    pub(super) motions: Vec<Motions>,
}

/// Whether an effect with these values changes nothing: all its parameters that have a value at which they are off take it, and it does not act
/// there.
pub(super) fn is_absent<S: EffectScalar>(effect: &dyn AnyEffect, values: &[S]) -> bool {
    let pairs = effect.info().parameters.iter().zip(values);
    let mut magnitudes = pairs.filter_map(|(p, value)| Some((p.off?, value.real()))).peekable();
    !effect.acts_where_off()
        && magnitudes.peek().is_some()
        && magnitudes.all(|(off, value)| off == value)
}

/// Rows behind the end of the open part of a recording that are simulated with it: windows end at whole rows.
const ROWS_AHEAD: usize = 2;

impl<'a> JointSystem<'a> {
    /// Place of the lead of the force among the shared nuisances.
    pub(super) const LEAD: usize = 2;
    /// Place of the share of the doubtful force that is noise.
    pub(super) const FORCE_NOISE: usize = 3;
    /// Places of the offsets of the pressures among the nuisances of a recording.
    const OFFSETS: std::ops::Range<usize> = 4..6;
    /// Place of the first share of an effect that baseline recordings have shown.
    pub(super) const SHARES: usize = 4;

    /// A system of trials of a model with its own numbers, effects that are part of it, and candidates. Starting values
    /// of candidates follow from the magnitudes of the parts of trials in `open`.
    #[must_use]
    pub fn new(
        trials: Vec<&'a Trial>,
        open: &[OpenPart],
        base: Base<f64>,
        fixed: &[ActiveEffect],
        effects: Vec<&'static dyn AnyEffect>,
        settings: &DiagnosisSettings,
    ) -> Self {
        let fit = &settings.fit;
        let lead = Nuisance {
            deviation: fit.lead_deviation_samples,
            limits: [-fit.lag_limit_samples, fit.lead_limit_samples],
        };
        let force_noise = Nuisance { deviation: fit.force_noise_deviation, limits: [0.0, 1.0] };
        let outputs = Channel::ALL.map(|c| OutputInfo {
            key: c.key().to_owned(),
            name: match c {
                Channel::X => "displacement",
                Channel::V => "velocity",
                Channel::Pf => "flexor pressure",
                Channel::Pe => "extensor pressure",
            }
            .to_owned(),
            unit: c.unit().to_owned(),
            // The velocity is the derivative of the displacement in every data format.
            fitted: c != Channel::V,
        });
        let (model, air) = (Nuisance::of(fit.model_deviation), Nuisance::of(fit.air_deviation));
        let start = StartDeviations::of(&trials, open, fit);
        let offset = Nuisance::of(start.pressure_kpa);
        let mut open_points: Vec<usize> = trials.iter().map(|t| t.record.points()).collect();
        for part in open {
            let record = &trials[part.experiment].record;
            let ahead = ROWS_AHEAD * settings.data.points_per_row;
            open_points[part.experiment] =
                record.points_for(record.points_within(part.end_s).saturating_add(ahead));
        }
        let steps = |t: &&Trial| t.record.steps_per_point * needed_substeps(t, &base);
        Self {
            steps_per_point: trials.iter().map(steps).collect(),
            scales: data_scales(&trials, open, &base, &settings.data),
            trials,
            base,
            fixed: fixed.to_vec(),
            learned: Vec::new(),
            effects,
            terms: Vec::new(),
            shared: vec![model, model, lead, force_noise],
            local: [Nuisance::of(start.mm), Nuisance::of(start.mm_s), air, air, offset, offset],
            outputs,
            settings: *settings,
            motions: open_points.iter().map(|_| motions::latest()).collect(),
            open_points,
        }
    }

    /// Widens the priors of the offsets of the first pressure samples by a standard deviation, kPa.
    pub(super) fn widen_offsets(&mut self, deviation_kpa: f64) {
        for offset in &mut self.local[Self::OFFSETS] {
            offset.deviation = offset.deviation.hypot(deviation_kpa);
        }
    }

    /// Takes over what baseline recordings have shown: their effects become a part of the model, and the priors of
    /// nuisances as wide as they need them. Of each effect, the data have a share between nothing and the
    /// whole: the whole, with the prior standard deviation of the baseline. More than the whole is no error of the model but
    /// a cause.
    pub(super) fn learn(&mut self, baseline: &BaselineDiscrepancy) {
        let share = |&deviation: &f64| Nuisance { deviation, limits: [-1.0, 0.0] };
        self.shared.extend(baseline.share_deviations.iter().map(share));
        self.learned.extend(baseline.effects.iter().cloned());
        Nuisance::widen(&mut self.local, &baseline.local_widenings);
    }

    /// The shares of the effects from the baseline recordings under a hypothesis.
    pub(super) fn shares(h: &Hypothesis) -> Vec<f64> {
        h.shared[Self::SHARES..].iter().map(|missing| 1.0 + missing).collect()
    }

    /// The effects from the baseline recordings as far as the data have them.
    pub(super) fn learned_in_part(&self, h: &Hypothesis) -> Vec<ActiveEffect> {
        let shares = Self::shares(h);
        self.learned.iter().zip(shares).map(|(effect, share)| in_part(effect, share)).collect()
    }

    /// The magnitudes from which starting values follow.
    #[must_use]
    pub fn scales(&self) -> &DataScales {
        &self.scales
    }

    /// Prior knowledge of the noise: the model's own errors, as a part of the motion.
    #[must_use]
    pub fn noise_prior(&self, open: &[OpenPart]) -> NoisePrior {
        NoisePrior {
            least: vec![f64::MIN_POSITIVE.sqrt(); Channel::ALL.len() - 1],
            discrepancy: moving_discrepancy(self, open, &self.settings.noise),
            given: Vec::new(),
        }
    }

    /// First estimate of the noise of each fitted channel, known deviations in its place, and the prior with them.
    pub(super) fn first_noise(
        &self,
        open: &[OpenPart],
        known: [Option<f64>; 3],
    ) -> (Vec<f64>, NoisePrior) {
        let estimated = estimated_noise(self, open, &self.settings.noise);
        let noise = estimated.into_iter().zip(known).map(|(noise, known)| known.unwrap_or(noise));
        (noise.collect(), NoisePrior { given: known.to_vec(), ..self.noise_prior(open) })
    }

    /// The effect of a candidate.
    pub(super) fn effect(&self, candidate: usize) -> &dyn AnyEffect {
        match candidate.checked_sub(self.effects.len()) {
            None => self.effects[candidate],
            Some(k) => self.terms[k].0,
        }
    }

    /// The effects of the model and of a hypothesis in an experiment, in the order in which they act.
    pub(super) fn parts(&self, h: &Hypothesis, experiment: usize) -> Parts<'_> {
        let of_model: Vec<ActiveEffect> =
            self.fixed.iter().cloned().chain(self.learned_in_part(h)).collect();
        let (effects, values) = ActiveEffect::split(&of_model);
        let mut parts = Parts { effects, values, places: Vec::new() };
        for member in &h.members {
            match member.candidate.checked_sub(self.effects.len()) {
                None => parts.add(self.effects[member.candidate], member, experiment),
                Some(k) => parts.add_always(self.terms[k].0, member),
            }
        }
        parts
    }

    /// A member as a part of a model: with its times where all recordings share them, else as it is when it acts.
    pub(super) fn active(&self, member: &Member) -> ActiveEffect {
        let effect = self.effects[member.candidate];
        let own = member.own();
        let always = ActiveEffect { effect, values: own.to_vec() };
        let Some(schedule) = member.schedule.as_ref().filter(|s| s.pattern == Pattern::Shared)
        else {
            return always;
        };
        match schedule.acts.first() {
            Some(Acts::Within(course, first)) => {
                let times = &member.times()[*first..first + course.time_len()];
                let (parameters, switches) = own.split_at(effect.info().parameters.len());
                let values = [parameters, times, switches].concat();
                ActiveEffect { effect: timed(effect, *course), values }
            }
            _ => always,
        }
    }

    /// Nuisances: mass, deformation coefficient (logarithms), lead and noise of the force, before the shares of learned effects; start,
    /// sealed masses (logarithms); the offsets of the pressures behind them are added to the simulated channels.
    pub(super) fn nuisances<S: EffectScalar>(h: &Hypothesis, local: &[f64]) -> Nuisances<S> {
        let c = S::constant;
        Nuisances {
            log_mass: c(h.shared[0]),
            log_deformation: c(h.shared[1]),
            lead_samples: h.shared[Self::LEAD],
            force_noise_share: c(h.shared[Self::FORCE_NOISE]),
            start_mm: c(local[0]),
            start_mm_s: c(local[1]),
            log_air: [c(local[2]), c(local[3])],
        }
    }
}

impl Candidates for JointSystem<'_> {
    fn candidate_len(&self) -> usize {
        self.effects.len() + self.terms.len()
    }

    fn candidate(&self, index: usize) -> CandidateInfo<'_> {
        let info = self.effect(index).info();
        CandidateInfo {
            id: info.id,
            description: info.description,
            excited_by: info.excited_by,
            parameters: info.parameters,
            value_len: info.value_len(),
        }
    }

    fn starts(&self, index: usize) -> Vec<Vec<f64>> {
        self.effect(index).starts(&self.scales)
    }

    fn stands(&self, index: usize, values: &[f64]) -> bool {
        self.effect(index).stands(values, &self.scales)
    }

    fn acts_where_off(&self, index: usize) -> bool {
        self.effect(index).acts_where_off()
    }

    /// Where the joint sticks and slips, the cost is rugged in the parameters of dry friction.
    fn is_rugged(&self, index: usize, values: &[f64]) -> bool {
        let effect = self.effect(index);
        let joint = FixedState::at_rest([self.scales.gauge_kpa + ATMOSPHERE_KPA; 2]);
        let memory = vec![0.0; effect.memory_len()];
        effect.may_stick_later(values)
            || f64::hooks(effect).dry_friction_mn(values, &joint.point(), &memory) > 0.0
    }

    fn parameter_deviation(&self, candidate: usize, parameter: usize) -> f64 {
        let terms = candidate.checked_sub(self.effects.len()).map(|k| &self.terms[k].1);
        terms.and_then(|own| own.get(parameter)).copied().unwrap_or(f64::INFINITY)
    }

    fn may_be_timed(&self, index: usize) -> bool {
        index < self.effects.len()
    }

    fn acts_at_rest(&self, index: usize) -> bool {
        let effect = self.effect(index);
        effect.hooks().rest || effect.changes_gas()
    }

    fn shared(&self) -> &[Nuisance] {
        &self.shared
    }

    fn timing(&self) -> Option<usize> {
        Some(Self::LEAD)
    }

    fn local(&self) -> &[Nuisance] {
        &self.local
    }

    fn experiment_len(&self) -> usize {
        self.trials.len()
    }

    fn outputs(&self) -> &[OutputInfo] {
        &self.outputs
    }

    fn name(&self, experiment: usize) -> &str {
        &self.trials[experiment].record.source.name
    }

    fn points(&self, experiment: usize) -> usize {
        self.trials[experiment].record.points()
    }

    /// Those of the open part, or all.
    fn simulated_points(&self, experiment: usize, until: usize) -> usize {
        let trial = &self.trials[experiment].record;
        let open = self.open_points[experiment];
        // The time series is differentiated by central differences.
        if trial.points_for(until + 1) <= open { open } else { trial.points() }
    }

    fn steps(&self, experiment: usize, until: usize) -> usize {
        self.simulated_points(experiment, until) * self.steps_per_point[experiment]
    }

    fn time_s(&self, experiment: usize, point: usize) -> f64 {
        point as f64 * self.trials[experiment].record.step_s
    }

    fn start_s(&self, experiment: usize) -> f64 {
        self.trials[experiment].record.source.start_s
    }

    fn point_at(&self, experiment: usize, time_s: f64) -> usize {
        let t = &self.trials[experiment].record;
        ((time_s / t.step_s) as usize).min(t.points())
    }

    fn resolution(&self, experiment: usize, output: usize) -> f64 {
        self.trials[experiment].record.resolution[output]
    }

    fn measured(&self, experiment: usize, output: usize) -> &[f64] {
        &self.trials[experiment].record.measured[output]
    }

    fn points_per_row(&self) -> usize {
        // Sparse recordings have grid points of more than 4 ms.
        let shortest_s = self.trials.iter().map(|t| t.record.step_s).fold(f64::INFINITY, f64::min);
        let points = self.settings.data.points_per_row as f64;
        let row_s = points * ResampledRecord::STEP_S;
        (row_s / shortest_s).round().clamp(1.0, points) as usize
    }

    fn burn_in_s(&self) -> f64 {
        self.settings.data.burn_in_s
    }

    fn burn_out_s(&self) -> f64 {
        self.settings.data.burn_out_s
    }

    fn rows_per_block(&self, _rows: usize, row_s: f64) -> usize {
        ((self.settings.intervals.block_s / row_s.max(1e-300)).round() as usize).max(1)
    }

    fn simulate(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        until: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let Parts { effects, values, .. } = self.parts(hypothesis, experiment);
        let nuisances = Self::nuisances(hypothesis, local);
        let (trial, points) = (self.trials[experiment], self.simulated_points(experiment, until));
        let mut out = Trajectory::default();
        simulate_until(trial, &self.base, &effects, &values, &nuisances, points, &mut out)
            .map_err(|diverged| diverges(trial, diverged))?;
        for (channel, &offset) in out.channels[2..].iter_mut().zip(&local[4..]) {
            if offset != 0.0 {
                channel.iter_mut().for_each(|p| *p += offset);
            }
        }
        Ok(out.channels.into())
    }

    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        Experiment { system: self, hypothesis, local, index: experiment }.sensitivities(&window)
    }

    fn parameter_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        Experiment { system: self, hypothesis, local, index: experiment }.of_parameters(&window)
    }

    fn features(
        &self,
        _hypothesis: &Hypothesis,
        _local: &[f64],
        experiment: usize,
        simulated: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        // The predicted motion: the measured one holds the noise that is to be told from an error.
        let (trial, mass_kg) = (self.trials[experiment], self.base.mass_kg);
        let motion = [simulated[0].as_slice(), simulated[1].as_slice()];
        Ok(features::features(trial, motion, mass_kg, &self.settings.verdict))
    }

    fn factor_names(&self) -> Vec<(String, String)> {
        factors::NAMES.iter().map(|(name, unit)| ((*name).into(), (*unit).into())).collect()
    }

    fn factors(
        &self,
        _hypothesis: &Hypothesis,
        _local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let (trial, rows) = (self.trials[experiment], self.points_per_row());
        Ok(factors::factors(trial, window, rows, &self.settings.residual))
    }

    fn excitation_label(&self) -> String {
        "force (N)".into()
    }

    fn excitation(&self, experiment: usize) -> Vec<f64> {
        let record = &self.trials[experiment].record;
        (0..record.points()).map(|k| record.force_mn(k) / MN_PER_N).collect()
    }
}
