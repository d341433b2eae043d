//! A system that does not simulate twice what it simulated lately.

use super::candidates::{CandidateInfo, Candidates, Nuisance, OutputInfo};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Sensitivities};
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// Memory for results of one kind, bytes.
const MOST_BYTES: usize = 96 << 20;

/// A system with its latest simulations and sensitivities. A hypothesis is asked for again with another noise, in other rows, and
/// once for each number that is read of it; what is simulated depends on its values alone.
///
/// Results are the same bits with and without memory, so that it does not matter which thread came first.
pub(crate) struct Remembered<'a, C: ?Sized> {
    system: &'a C,
    simulations: Store<Vec<Vec<f64>>>,
    sensitivities: Store<Sensitivities>,
}

/// What a result depends on.
struct Key {
    members: Vec<Member>,
    fixed: usize,
    shared: Vec<f64>,
    local: Vec<f64>,
    experiment: usize,
    /// Grid points that are simulated.
    points: usize,
}

/// The latest results, the last one behind, with their windows.
struct Store<R>(Mutex<Entries<R>>);

struct Entries<R> {
    all: VecDeque<(Key, Range<usize>, Arc<R>)>,
    bytes: usize,
}

/// A result of a simulation.
trait Remember {
    /// Its numbers.
    fn len(&self) -> usize;
}

impl Remember for Vec<Vec<f64>> {
    fn len(&self) -> usize {
        self.iter().map(Vec::len).sum()
    }
}

impl Remember for Sensitivities {
    fn len(&self) -> usize {
        let columns = self.columns.iter().map(Remember::len).sum::<usize>();
        columns + Remember::len(&self.residuals)
    }
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

impl<R: Remember> Store<R> {
    fn new() -> Self {
        Self(Mutex::new(Entries { all: VecDeque::new(), bytes: 0 }))
    }

    /// The result of a key whose window `serves`.
    fn find(
        &self,
        key: &Key,
        serves: impl Fn(&Range<usize>) -> bool,
    ) -> Option<(Range<usize>, Arc<R>)> {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = entries.all.iter().rposition(|(k, window, _)| k.is(key) && serves(window))?;
        let found = entries.all.remove(at)?;
        let result = (found.1.clone(), Arc::clone(&found.2));
        entries.all.push_back(found);
        Some(result)
    }

    fn keep(&self, key: Key, window: Range<usize>, result: Arc<R>) {
        let size = |result: &R| size_of::<f64>() * result.len();
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        entries.bytes += size(&result);
        entries.all.push_back((key, window, result));
        while entries.bytes > MOST_BYTES {
            let Some((.., oldest)) = entries.all.pop_front() else { break };
            entries.bytes -= size(&oldest);
        }
    }
}

impl<'a, C: Candidates + ?Sized> Remembered<'a, C> {
    pub(crate) fn new(system: &'a C) -> Self {
        Self { system, simulations: Store::new(), sensitivities: Store::new() }
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

    /// Sensitivities from memory, or worked out: those of a window hold those of its whole rows.
    fn of_window(
        &self,
        key: Key,
        window: Range<usize>,
        work_out: impl FnOnce() -> Result<Sensitivities, DiagnoseError>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let points = self.system.points_per_row();
        let serves = |wide: &Range<usize>| {
            wide.start <= window.start
                && window.end <= wide.end
                && (window.start - wide.start).is_multiple_of(points)
        };
        if let Some((wide, found)) = self.sensitivities.find(&key, serves) {
            if wide == window {
                return Ok(Sensitivities::clone(&found));
            }
            let first = (window.start - wide.start) / points;
            return Ok(found.rows(&(first..first + window.len() / points)));
        }
        let found = work_out()?;
        self.sensitivities.keep(key, window, Arc::new(found.clone()));
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
        let key = self.key(hypothesis, local, experiment, until);
        if let Some((_, found)) = self.simulations.find(&key, |_| true) {
            return Ok(Vec::clone(&found));
        }
        let found = self.system.simulate(hypothesis, local, experiment, until)?;
        self.simulations.keep(key, 0..until, Arc::new(found.clone()));
        Ok(found)
    }

    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let key = self.key(hypothesis, local, experiment, window.end);
        let key = Key { fixed: hypothesis.fixed, ..key };
        self.of_window(key, window.clone(), || {
            self.system.sensitivities(hypothesis, local, experiment, window)
        })
    }

    // Directions of candidates are asked for once.
    fn parameter_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
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
