//! The engine of models with effects.

use super::operating_model::OperatingModel;
use super::window::{WindowGradient, Workspace};
use crate::effects::AnyEffect;
use crate::model::ActiveEffect;
use crate::simulation::{Base, ResampledRecord};
use pam_autodiff::batch::BatchNetwork;
use pam_core::JointModel;
use pam_core::parallel;
use pam_core::simd::Float;
use pam_solvers::{FailureKind, TrajectoryFailure};
use pam_trajectory::Windows;
use pam_trajectory::engine::{
    EngineError, EngineForce, GradientStatistics, GradientSums, IndexedLoss, Precision,
    TrajectoryEngine, TrajectoryGradient, TrajectoryRequest,
};
use rayon::prelude::*;
use std::sync::Mutex;

/// Largest number of groups of windows. It does not depend on the number of threads, so that sums are the same
/// bits.
const GROUPS: usize = 64;

/// A network with effects, simulated by the steps of [`simulate`](crate::simulation::simulate). Slopes and weight
/// sums of the network are in `T`, everything else in doubles.
#[derive(Debug)]
pub struct EffectsEngine<T> {
    effects: Vec<&'static dyn AnyEffect>,
    /// Parameters and switches in turn; the parameters are replaced in every call.
    values: Vec<f64>,
    /// The id of the windows that `records` were resampled from.
    windows: Option<u64>,
    records: Vec<ResampledRecord>,
    slots: Vec<Slot>,
    workspaces: Mutex<Vec<Workspace<T>>>,
}

/// The results of one window.
#[derive(Debug, Default)]
struct Slot {
    predicted: Vec<[f64; 4]>,
    by_predicted: Vec<[f64; 4]>,
    value: f64,
    failed_s: Option<f64>,
    gradient: WindowGradient,
}

impl<T: Float> EffectsEngine<T> {
    /// An engine for these effects; their switches stay as they are.
    #[must_use]
    pub fn new(effects: &[ActiveEffect]) -> Self {
        let (effects, values) = ActiveEffect::split(effects);
        Self {
            effects,
            values,
            windows: None,
            records: Vec::new(),
            slots: Vec::new(),
            workspaces: Mutex::default(),
        }
    }

    /// Resamples windows, unless they are those of the last call.
    fn prepare(&mut self, windows: &Windows) -> Result<(), EngineError> {
        if self.windows == Some(windows.id()) {
            return Ok(());
        }
        let whole = windows.since_s.iter().all(|&t| t == 0.0);
        if let Some(effect) = self.effects.iter().find(|e| e.remembers() && !whole) {
            return Err(EngineError::Effect {
                id: effect.info().id.into(),
                message: "it depends on what was before, which a window within a recording does not show; \
                          train it on whole recordings, without horizon_s"
                    .into(),
            });
        }
        for subject in windows.subjects() {
            ResampledRecord::check(subject).map_err(|e| EngineError::Request(e.to_string()))?;
        }
        let record = |(subject, &since_start_s)| ResampledRecord {
            since_start_s,
            ..ResampledRecord::dense(subject)
        };
        let subjects = windows.subjects();
        self.records =
            parallel::map(subjects.len(), |k| record((&subjects[k], &windows.since_s[k])));
        self.windows = Some(windows.id());
        Ok(())
    }

    /// Replaces the parameters.
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), EngineError> {
        let count: usize = self.effects.iter().map(|e| e.info().parameters.len()).sum();
        if parameters.len() != count {
            return Err(EngineError::Request(format!(
                "{} values for the {count} parameters of the effects",
                parameters.len()
            )));
        }
        let (mut from, mut to) = (0, 0);
        for effect in &self.effects {
            let (own, all) = (effect.info().parameters.len(), effect.info().value_len());
            self.values[to..to + own].copy_from_slice(&parameters[from..from + own]);
            from += own;
            to += all;
        }
        Ok(())
    }

    /// The parameters among parameters and switches.
    fn parameters_of(&self, values: &[f64]) -> Vec<f64> {
        let mut rest = values;
        let mut parameters = Vec::new();
        for effect in &self.effects {
            let (own, next) = rest.split_at(effect.info().value_len());
            parameters.extend_from_slice(&own[..effect.info().parameters.len()]);
            rest = next;
        }
        parameters
    }

    /// The gradient of the mean loss from the results of the windows.
    fn gradient<F>(
        &self,
        request: &TrajectoryRequest<'_, F>,
        force: Vec<f64>,
    ) -> TrajectoryGradient {
        let slots = &self.slots[..request.len()];
        let record = |k: usize| &self.records[request.window(k)];
        let failure = |(problem, slot): (usize, &Slot)| {
            slot.failed_s.map(|time_s| TrajectoryFailure {
                problem,
                kind: FailureKind::NonFinite { step_s: ResampledRecord::STEP_S },
                time_s: request.subject(problem).recording.time_s[0] + time_s,
            })
        };
        let mut sums = GradientSums {
            values: slots
                .iter()
                .map(|s| if s.failed_s.is_none() { s.value } else { f64::NAN })
                .collect(),
            force,
            joint_by_raw: GradientSums::physical_by_raw(request.model),
            masses: vec![[0.0; 2]; slots.len()],
            initial_states: vec![[0.0; 4]; slots.len()],
            failures: slots.iter().enumerate().filter_map(failure).collect(),
            statistics: GradientStatistics {
                accepted: (0..slots.len()).map(|k| record(k).points() - 1).sum(),
                ..GradientStatistics::default()
            },
            ..GradientSums::default()
        };
        let mut values = vec![0.0; self.values.len()];
        for (k, slot) in slots.iter().enumerate().filter(|(_, s)| s.failed_s.is_none()) {
            let WindowGradient { values: own, physical, log_air, start } = &slot.gradient;
            values.iter_mut().zip(own).for_each(|(sum, v)| *sum += v);
            sums.joint.iter_mut().zip(physical).for_each(|(sum, v)| *sum += v);
            sums.auxiliary_damping += physical[3];
            let masses = record(k).masses;
            sums.masses[k] = [log_air[0] / masses.flexor_g, log_air[1] / masses.extensor_g];
            sums.initial_states[k] = *start;
        }
        TrajectoryGradient::mean_of(GradientSums { effects: self.parameters_of(&values), ..sums })
    }
}

impl<T: Float, F: EngineForce> TrajectoryEngine<F> for EffectsEngine<T> {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        request.check()?;
        self.prepare(request.windows)?;
        self.set_parameters(request.effects)?;
        let JointModel { force, .. } = request.model;
        let force = force.network().ok_or_else(|| {
            EngineError::Request(
                "the force of the model is no network; gradients of extended models are those of networks"
                    .into(),
            )
        })?;
        let network = BatchNetwork::<T>::new(force.mlp(), 0);
        let first_bias = network.fold(&[]);
        let plain = BatchNetwork::<f64>::new(force.mlp(), 0);
        let plain_bias = plain.fold(&[]);
        let weights_len = network.parameter_len();
        let count = request.len();
        if self.slots.len() < count {
            self.slots.resize_with(count, Slot::default);
        }
        let at = OperatingModel {
            base: Base::of(request.model),
            plain: &plain,
            plain_bias: &plain_bias,
            network: &network,
            first_bias: &first_bias,
            effects: &self.effects,
            values: &self.values,
        };
        let (records, workspaces) = (&self.records, &self.workspaces);
        let size = count.div_ceil(GROUPS).max(1);
        let groups: Vec<Vec<f64>> = self.slots[..count]
            .par_chunks_mut(size)
            .enumerate()
            .with_max_len(1)
            .map(|(group, slots)| {
                let kept = workspaces.lock().expect("no panic holds it").pop();
                let mut work = kept.unwrap_or_else(|| Workspace::new(&network, &plain));
                let mut by_weights = vec![0.0; if backward { weights_len } else { 0 }];
                for (k, slot) in slots.iter_mut().enumerate() {
                    let k = group * size + k;
                    let record = &records[request.window(k)];
                    let (measured, start) = (&request.subject(k).recording, request.start(k));
                    let time_s = &measured.time_s;
                    let reached = work.forward(&at, record, time_s, start, &mut slot.predicted);
                    slot.failed_s = reached.err().map(|d| d.time_s);
                    if slot.failed_s.is_some() {
                        continue;
                    }
                    slot.by_predicted.resize(time_s.len(), [0.0; 4]);
                    slot.value = loss(k, measured, &slot.predicted, &mut slot.by_predicted);
                    if backward {
                        let by = &slot.by_predicted;
                        slot.gradient =
                            work.backward(&at, record, time_s, start, by, &mut by_weights);
                    }
                }
                workspaces.lock().expect("no panic holds it").push(work);
                by_weights
            })
            .collect();
        let mut by_weights = vec![0.0; weights_len];
        for group in groups {
            by_weights.iter_mut().zip(group).for_each(|(sum, v)| *sum += v);
        }
        Ok(self.gradient(request, by_weights))
    }

    fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        &self.slots[index].predicted
    }

    fn precision(&self) -> Precision {
        if size_of::<T>() == size_of::<f32>() { Precision::F32 } else { Precision::F64 }
    }
}
