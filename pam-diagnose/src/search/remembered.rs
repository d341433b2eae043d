//! A system that keeps its most recently used simulations.

use super::candidates::{CandidateInfo, Candidates, Nuisance, OutputInfo};
use super::work::Work;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Sensitivities};
use pam_core::Latest;
use std::ops::Range;
use std::sync::Arc;

/// Memory for results of one kind, bytes.
const MOST_BYTES: usize = 96 << 20;

/// A system that keeps its most recently used simulations and sensitivities. The same hypothesis is evaluated with another noise, in
/// other rows and for other statistics; its simulation depends on its values alone.
///
/// Results have the same bits whether they were kept or not, at any number of threads.
pub(crate) struct Remembered<'a, C: ?Sized> {
    system: &'a C,
    simulations: Latest<Key, Vec<Vec<f64>>>,
    /// With their windows.
    sensitivities: Latest<(Key, Range<usize>), Sensitivities>,
    work: Arc<Work>,
}

/// The numbers that a result follows from.
struct Key {
    members: Vec<Member>,
    fixed: usize,
    shared: Vec<f64>,
    local: Vec<f64>,
    experiment: usize,
    /// Grid points that are simulated.
    points: usize,
}

/// Size of channels, bytes.
fn bytes(channels: &[Vec<f64>]) -> usize {
    size_of::<f64>() * channels.iter().map(Vec::len).sum::<usize>()
}

impl Sensitivities {
    /// The rows of a part of its window.
    fn rows(&self, rows: &Range<usize>) -> Self {
        let cut = |channels: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            let cut = |c: &Vec<f64>| c.get(rows.clone()).map(<[f64]>::to_vec).unwrap_or_default();
            channels.iter().map(cut).collect()
        };
        Self { residuals: cut(&self.residuals), columns: self.columns.iter().map(cut).collect() }
    }
}

fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

impl Key {
    fn is(&self, other: &Self) -> bool {
        let same = |(a, b): (&Member, &Member)| {
            a.candidate == b.candidate
                && same_bits(&a.values, &b.values)
                && a.schedule == b.schedule
        };
        self.experiment == other.experiment
            && self.points == other.points
            && self.fixed == other.fixed
            && same_bits(&self.local, &other.local)
            && same_bits(&self.shared, &other.shared)
            && self.members.len() == other.members.len()
            && self.members.iter().zip(&other.members).all(same)
    }
}

impl<'a, C: Candidates + ?Sized> Remembered<'a, C> {
    /// `work` counts every request, whether it is answered from the cache or not.
    pub(crate) fn new(system: &'a C, work: Arc<Work>) -> Self {
        Self {
            system,
            work,
            simulations: Latest::new(MOST_BYTES),
            sensitivities: Latest::new(MOST_BYTES),
        }
    }

    /// Counts a simulation with this number of derivatives.
    fn count(&self, h: &Hypothesis, experiment: usize, until: usize, derivatives: usize) {
        let values = h.members.iter().map(|m| m.values.len()).sum();
        self.work.add(self.system.steps(experiment, until), values, derivatives);
    }

    fn key(&self, h: &Hypothesis, local: &[f64], experiment: usize, until: usize) -> Key {
        Key {
            members: h.members.clone(),
            fixed: 0,
            shared: h.shared.clone(),
            local: local.to_vec(),
            experiment,
            points: self.system.simulated_points(experiment, until),
        }
    }

    /// Sensitivities, kept or computed. Those of a window serve every window of whole rows inside it.
    fn of_window(
        &self,
        key: Key,
        window: Range<usize>,
        compute: impl FnOnce() -> Result<Sensitivities, DiagnoseError>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let points = self.system.points_per_row();
        let serves = |(of, wide): &(Key, Range<usize>)| {
            let holds = wide.start <= window.start
                && window.end <= wide.end
                && (window.start - wide.start).is_multiple_of(points);
            (holds && of.is(&key)).then(|| wide.clone())
        };
        if let Some((wide, found)) = self.sensitivities.find(serves) {
            if wide == window {
                return Ok(Sensitivities::clone(&found));
            }
            let first = (window.start - wide.start) / points;
            return Ok(found.rows(&(first..first + window.len() / points)));
        }
        let found = compute()?;
        let size = bytes(&found.residuals) + found.columns.iter().map(|c| bytes(c)).sum::<usize>();
        self.sensitivities.keep((key, window), Arc::new(found.clone()), size);
        Ok(found)
    }
}

impl<C: Candidates + ?Sized> Candidates for Remembered<'_, C> {
    fn candidate_len(&self) -> usize {
        self.system.candidate_len()
    }

    fn candidate(&self, index: usize) -> CandidateInfo<'_> {
        self.system.candidate(index)
    }

    fn starts(&self, index: usize) -> Vec<Vec<f64>> {
        self.system.starts(index)
    }

    fn stands(&self, index: usize, values: &[f64]) -> bool {
        self.system.stands(index, values)
    }

    fn acts_where_off(&self, index: usize) -> bool {
        self.system.acts_where_off(index)
    }

    fn is_rugged(&self, index: usize, values: &[f64]) -> bool {
        self.system.is_rugged(index, values)
    }

    fn parameter_deviation(&self, candidate: usize, parameter: usize) -> f64 {
        self.system.parameter_deviation(candidate, parameter)
    }

    fn may_be_timed(&self, index: usize) -> bool {
        self.system.may_be_timed(index)
    }

    fn acts_at_rest(&self, index: usize) -> bool {
        self.system.acts_at_rest(index)
    }

    fn ramp_s(&self) -> f64 {
        self.system.ramp_s()
    }

    fn shared(&self) -> &[Nuisance] {
        self.system.shared()
    }

    fn timing(&self) -> Option<usize> {
        self.system.timing()
    }

    fn local(&self) -> &[Nuisance] {
        self.system.local()
    }

    fn experiment_len(&self) -> usize {
        self.system.experiment_len()
    }

    fn outputs(&self) -> &[OutputInfo] {
        self.system.outputs()
    }

    fn name(&self, experiment: usize) -> &str {
        self.system.name(experiment)
    }

    fn points(&self, experiment: usize) -> usize {
        self.system.points(experiment)
    }

    fn simulated_points(&self, experiment: usize, until: usize) -> usize {
        self.system.simulated_points(experiment, until)
    }

    fn steps(&self, experiment: usize, until: usize) -> usize {
        self.system.steps(experiment, until)
    }

    fn time_s(&self, experiment: usize, point: usize) -> f64 {
        self.system.time_s(experiment, point)
    }

    fn start_s(&self, experiment: usize) -> f64 {
        self.system.start_s(experiment)
    }

    fn point_at(&self, experiment: usize, time_s: f64) -> usize {
        self.system.point_at(experiment, time_s)
    }

    fn measured(&self, experiment: usize, output: usize) -> &[f64] {
        self.system.measured(experiment, output)
    }

    fn resolution(&self, experiment: usize, output: usize) -> f64 {
        self.system.resolution(experiment, output)
    }

    fn points_per_row(&self) -> usize {
        self.system.points_per_row()
    }

    fn burn_in_s(&self) -> f64 {
        self.system.burn_in_s()
    }

    fn burn_out_s(&self) -> f64 {
        self.system.burn_out_s()
    }

    fn rows_per_block(&self, rows: usize, row_s: f64) -> usize {
        self.system.rows_per_block(rows, row_s)
    }

    fn simulate(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        until: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        self.count(hypothesis, experiment, until, 0);
        let key = self.key(hypothesis, local, experiment, until);
        if let Some((_, found)) = self.simulations.find(|k| k.is(&key).then_some(())) {
            return Ok(Vec::clone(&found));
        }
        let found = self.system.simulate(hypothesis, local, experiment, until)?;
        self.simulations.keep(key, Arc::new(found.clone()), bytes(&found));
        Ok(found)
    }

    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let nuisances = self.shared().len() + self.local().len();
        let derivatives = hypothesis.parameters(self.system).len() + nuisances;
        self.count(hypothesis, experiment, window.end, derivatives);
        let key = self.key(hypothesis, local, experiment, window.end);
        let key = Key { fixed: hypothesis.fixed, ..key };
        self.of_window(key, window.clone(), || {
            self.system.sensitivities(hypothesis, local, experiment, window)
        })
    }

    // Directions of candidates are needed once, and not kept.
    fn parameter_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let derivatives = hypothesis.parameters(self.system).len();
        self.count(hypothesis, experiment, window.end, derivatives);
        self.system.parameter_sensitivities(hypothesis, local, experiment, window)
    }

    fn features(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        simulated: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        self.system.features(hypothesis, local, experiment, simulated)
    }

    fn factor_names(&self) -> Vec<(String, String)> {
        self.system.factor_names()
    }

    fn factors(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        self.system.factors(hypothesis, local, experiment, window)
    }

    fn excitation_label(&self) -> String {
        self.system.excitation_label()
    }

    fn excitation(&self, experiment: usize) -> Vec<f64> {
        self.system.excitation(experiment)
    }

    fn strata(&self, experiment: usize, window: Range<usize>) -> Vec<(String, Range<usize>)> {
        self.system.strata(experiment, window)
    }
}
