//! Loss and gradient over windows, on all threads.

use super::window::{At, WindowGradient, Workspace};
use crate::effects::AnyEffect;
use crate::simulation::ResampledRecord;
use pam_autodiff::batch::BatchNetwork;
use pam_core::simd::Float;
use pam_core::{RawParameters, Scalar, SealedMasses};
use pam_solvers::{FailureKind, TrajectoryFailure};
use pam_trajectory::JointGradient;
use pam_trajectory::gradient::GradientStatistics;
use pam_trajectory::gradient::sealed::IndexedLoss;
use pam_trajectory::gradient::{ExtendedGradient, ExtendedRequest};
use pam_trajectory::windows::Windows;
use rayon::prelude::*;
use std::sync::Mutex;

/// Most groups of windows. Their number does not depend on that of the threads, so that sums are the same bits.
const GROUPS: usize = 64;

/// The gradient of a network with effects, again and again. Slopes and weight sums of the network in `T`,
/// everything else in doubles.
#[derive(Debug)]
pub struct EffectGradient<T> {
    effects: Vec<&'static dyn AnyEffect>,
    /// Parameters and switches; the parameters are replaced in every call.
    values: Vec<f64>,
    records: Vec<ResampledRecord>,
    slots: Vec<Slot>,
    workspaces: Mutex<Vec<Workspace<T>>>,
}

/// What a call finds for one window.
#[derive(Debug, Default)]
struct Slot {
    predicted: Vec<[f64; 4]>,
    by_predicted: Vec<[f64; 4]>,
    value: f64,
    failed_s: Option<f64>,
    gradient: WindowGradient,
}

impl<T: Float> EffectGradient<T> {
    /// For effects with values (parameters and switches in turn) on windows.
    #[must_use]
    pub fn new(effects: Vec<&'static dyn AnyEffect>, values: &[f64], windows: &Windows) -> Self {
        let record = |(subject, &since)| ResampledRecord {
            since_start_s: since,
            ..ResampledRecord::new(subject)
        };
        Self {
            effects,
            values: values.to_vec(),
            records: windows.subjects.par_iter().zip(&windows.since_s).map(record).collect(),
            slots: Vec::new(),
            workspaces: Mutex::default(),
        }
    }

    /// Replaces the parameters.
    fn set_parameters(&mut self, parameters: &[f64]) {
        let (mut from, mut to) = (0, 0);
        for effect in &self.effects {
            let (own, all) = (effect.info().parameters.len(), effect.info().value_len());
            self.values[to..to + own].copy_from_slice(&parameters[from..from + own]);
            from += own;
            to += all;
        }
    }

    /// Of parameters and switches the parameters.
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

    /// A gradient that sums to zero over no windows.
    fn assemble(&self, request: &ExtendedRequest<'_>, by_weights: Vec<f64>) -> JointGradient {
        let (model, part) = (request.model, request.part);
        let slots = &self.slots[..part.len()];
        let failures: Vec<TrajectoryFailure> = slots
            .iter()
            .enumerate()
            .filter_map(|(problem, slot)| {
                slot.failed_s.map(|time_s| TrajectoryFailure {
                    problem,
                    kind: FailureKind::NonFinite { step_s: ResampledRecord::STEP_S },
                    time_s: request.windows.subjects[part[problem]].recording.time_s[0] + time_s,
                })
            })
            .collect();
        let mean = 1.0 / (slots.len() - failures.len()).max(1) as f64;
        let sound = || slots.iter().filter(|s| s.failed_s.is_none());
        let mut values = vec![0.0; self.values.len()];
        let mut physical = [0.0; 4];
        for slot in sound() {
            let g = &slot.gradient;
            values.iter_mut().zip(&g.values).for_each(|(sum, v)| *sum += mean * v);
            physical.iter_mut().zip(g.physical).for_each(|(sum, v)| *sum += mean * v);
        }
        let raw = &model.raw;
        let own = |slot: &Slot| if slot.failed_s.is_none() { mean } else { 0.0 };
        JointGradient {
            value: mean * sound().map(|s| s.value).sum::<f64>(),
            values: slots
                .iter()
                .map(|s| if s.failed_s.is_none() { s.value } else { f64::NAN })
                .collect(),
            force: by_weights.into_iter().map(|v| mean * v).collect(),
            raw: RawParameters {
                mass: physical[0] * raw.mass.sigmoid(),
                gas_coefficient: physical[1] * raw.gas_coefficient.sigmoid(),
                deformation: physical[2] * raw.deformation.sigmoid(),
            },
            extension: self.parameters_of(&values),
            auxiliary_damping: physical[3],
            masses: slots
                .iter()
                .zip(part)
                .map(|(slot, &i)| {
                    let masses = self.records[i].masses;
                    let [flexor, extensor] = slot.gradient.log_air;
                    SealedMasses {
                        flexor_g: own(slot) * flexor / masses.flexor_g,
                        extensor_g: own(slot) * extensor / masses.extensor_g,
                    }
                })
                .collect(),
            initial_states: slots
                .iter()
                .map(|slot| slot.gradient.start.map(|v| own(slot) * v))
                .collect(),
            states: Vec::new(),
            failures,
            statistics: GradientStatistics {
                accepted: part.iter().map(|&i| self.records[i].points() - 1).sum(),
                ..GradientStatistics::default()
            },
        }
    }
}

impl<T: Float + std::fmt::Debug> ExtendedGradient for EffectGradient<T> {
    fn value_and_gradient(
        &mut self,
        request: &ExtendedRequest<'_>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> JointGradient {
        let ExtendedRequest { model, windows, part, starts, .. } = *request;
        self.set_parameters(request.values);
        let network = BatchNetwork::<T>::new(model.force.mlp(), 0);
        let first_bias = network.fold(&[]);
        let plain = BatchNetwork::<f64>::new(model.force.mlp(), 0);
        let plain_bias = plain.fold(&[]);
        let weights_len = network.parameter_len();
        if self.slots.len() < part.len() {
            self.slots.resize_with(part.len(), Slot::default);
        }
        let at = At {
            model,
            plain: &plain,
            plain_bias: &plain_bias,
            network: &network,
            first_bias: &first_bias,
            effects: &self.effects,
            values: &self.values,
        };
        let (records, workspaces) = (&self.records, &self.workspaces);
        let size = part.len().div_ceil(GROUPS).max(1);
        let groups: Vec<Vec<f64>> = self.slots[..part.len()]
            .par_chunks_mut(size)
            .enumerate()
            .with_max_len(1)
            .map(|(group, slots)| {
                let kept = workspaces.lock().expect("no panic holds it").pop();
                let mut work = kept.unwrap_or_else(|| Workspace::new(&network, &plain));
                let mut by_weights = vec![0.0; if backward { weights_len } else { 0 }];
                for (k, slot) in slots.iter_mut().enumerate() {
                    let k = group * size + k;
                    let record = &records[part[k]];
                    let measured = &windows.subjects[part[k]].recording;
                    let time_s = &measured.time_s;
                    let reached = work.forward(&at, record, time_s, starts[k], &mut slot.predicted);
                    slot.failed_s = reached.err().map(|d| d.time_s);
                    if slot.failed_s.is_some() {
                        continue;
                    }
                    slot.by_predicted.resize(time_s.len(), [0.0; 4]);
                    slot.value = loss(k, measured, &slot.predicted, &mut slot.by_predicted);
                    if backward {
                        slot.gradient = work.backward(
                            &at,
                            record,
                            time_s,
                            starts[k],
                            &slot.by_predicted,
                            &mut by_weights,
                        );
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
        self.assemble(request, by_weights)
    }

    fn predicted(&self, index: usize) -> &[[f64; 4]] {
        self.slots.get(index).map_or(&[], |slot| &slot.predicted)
    }
}
