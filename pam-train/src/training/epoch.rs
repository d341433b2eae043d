//! One epoch of a stage that is trained through the solver.

use super::error::TrainingError;
use super::state::{Best, EpochRow, OptimiserState, StageState};
use super::trainer::{Prepared, Trainer};
use crate::coordinates::Coordinates;
use crate::optimiser::{StepKind, clip_to_norm};
use crate::regulariser::{AnyRegulariser, Regulariser};
use pam_data::Recording;
use pam_trajectory::engine::{NetworkJoint, TrajectoryGradient, TrajectoryRequest};
use pam_trajectory::loss::TrajectoryLoss;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use std::time::Instant;

/// Share of the rate after rollbacks below which a stage is ended.
const SMALLEST_REDUCTION: f64 = 1e-6;

/// Loss and gradient of one step.
struct Step {
    loss: f64,
    gradient: Vec<f64>,
    by_starts: Vec<[f64; 4]>,
    failure: Option<String>,
}

impl Trainer {
    /// Does one epoch of the running stage.
    pub(super) fn epoch(&mut self, begun: Instant) -> Result<EpochRow, TrainingError> {
        let stage_index = self.state.stage;
        let prepared = self.stage.as_mut().expect("a stage is entered before its epochs");
        let within = self.state.within.as_mut().expect("a stage is entered before its epochs");
        let settings = prepared.settings.clone();
        let clip = settings.clip.unwrap_or(self.curriculum.clip);
        let base = settings.rate.unwrap_or(self.curriculum.rate);
        let (epoch, epochs) = (within.epoch, settings.epochs);
        let last_loss = within.best.as_ref().map_or(f64::INFINITY, |b| b.loss);
        let scheduled = within.rate.next(base, epoch, epochs, last_loss);
        let rate = scheduled * within.reduction;

        let count = prepared.windows.subjects().len();
        let batch = settings.batch.unwrap_or(count).min(count);
        let mut order: Vec<usize> = (0..count).collect();
        if batch < count {
            let mixed = self.seed ^ ((stage_index as u64) << 40) ^ epoch as u64;
            order.shuffle(&mut ChaCha8Rng::seed_from_u64(mixed));
        }
        let mut at = self.state.at.clone();
        // The coordinates whose loss the epoch finds: those that Adam starts from, those that a line
        // search ends at.
        let mut scored_at = at.clone();
        let sound = (at.clone(), within.optimiser.clone());
        let (mut loss_sum, mut norm, mut failure) = (0.0, 0.0_f64, None);
        if let OptimiserState::Lbfgs(mut lbfgs) = within.optimiser.clone() {
            let outcome = lbfgs.minimise_step(&mut at, &mut |candidate| {
                let regularisers = &self.curriculum.regularisers;
                let tried =
                    evaluate(prepared, &self.coordinates, regularisers, within, &order, candidate);
                match tried {
                    Ok(step) if step.failure.is_none() => Some((step.loss, step.gradient)),
                    Ok(step) => {
                        failure = step.failure;
                        None
                    }
                    Err(e) => {
                        failure = Some(e.to_string());
                        None
                    }
                }
            });
            (loss_sum, norm) = (outcome.value, outcome.gradient_norm);
            // Candidates of a line search may diverge; only a start that does is a failure.
            if outcome.kind != StepKind::Undefined {
                failure = None;
            }
            self.coordinates.project(&mut at);
            within.stopped = matches!(outcome.kind, StepKind::Stationary | StepKind::Stuck);
            within.optimiser = OptimiserState::Lbfgs(lbfgs);
            scored_at.clone_from(&at);
            order.clear();
        }
        for part in order.chunks(batch) {
            let regularisers = &self.curriculum.regularisers;
            let step = evaluate(prepared, &self.coordinates, regularisers, within, part, &at)?;
            loss_sum += step.loss * part.len() as f64 / count as f64;
            if let Some(why) = step.failure {
                failure = Some(why);
                break;
            }
            let mut gradient = step.gradient;
            norm = norm.max(clip_to_norm(&mut gradient, clip));
            if let OptimiserState::Adam(adam) = &mut within.optimiser {
                adam.step(&mut at, &gradient, rate);
                self.coordinates.project(&mut at);
            }
            if let (Some(starts), Some(shooting)) = (&mut within.starts, settings.shooting) {
                // In standard deviations of the channels, so that one rate fits all.
                let scales: Vec<[f64; 4]> =
                    prepared.windows.variance.iter().map(|v| v.map(f64::sqrt)).collect();
                let flat = |f: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
                    (0..4 * count).map(|k| f(k / 4, k % 4)).collect()
                };
                let mut scaled = flat(&|i, c| starts.states[i][c] / scales[i][c]);
                let slopes = flat(&|i, c| step.by_starts[i][c] * scales[i][c]);
                starts.optimiser.step(&mut scaled, &slopes, shooting.rate * rate / base);
                for (k, value) in scaled.into_iter().enumerate() {
                    starts.states[k / 4][k % 4] = value * scales[k / 4][k % 4];
                }
            }
        }

        within.epoch += 1;
        within.seconds += begun.elapsed().as_secs_f64();
        self.state.epochs += 1;
        if let Some(why) = failure {
            self.roll_back(&why, rate)?;
        } else {
            within.first_loss.get_or_insert(loss_sum);
            if loss_sum < last_loss {
                within.best = Some(Best { loss: loss_sum, at: scored_at, epoch });
            }
            if let Some(stop) = &mut within.stop {
                within.stopped |= stop.stops(loss_sum);
            }
            within.sound = Some(sound);
            self.state.at = at;
        }
        let physical = self.coordinates.model(&self.state.at).physical();
        Ok(EpochRow {
            stage: stage_index,
            epoch: epoch + 1,
            total_epoch: self.state.epochs,
            loss: loss_sum,
            rate,
            gradient_norm: norm,
            mass_kg: physical.mass_kg,
            deformation: physical.deformation,
            effects: self.coordinates.effect_parameters(&self.state.at),
            r2_held_out: None,
            seconds: begun.elapsed().as_secs_f64(),
        })
    }

    /// Goes back to the last coordinates whose solves ended, with half of the rate.
    fn roll_back(&mut self, why: &str, rate: f64) -> Result<(), TrainingError> {
        let within = self.state.within.as_mut().expect("a running stage");
        let stage = self.curriculum.stages[self.state.stage].name().to_owned();
        let epoch = within.epoch;
        let diverged =
            |message: String| TrainingError::Diverged { stage: stage.clone(), epoch, message };
        let Some((at, optimiser)) = within.sound.clone() else {
            return Err(diverged(format!(
                "{why} at the coordinates that the stage starts from; start it from a warm start, \
                 with a shorter horizon_s, or with auxiliary_damping"
            )));
        };
        if within.reduction < SMALLEST_REDUCTION {
            within.stopped = true;
            self.state.events.push(format!(
                "stage `{stage}`, epoch {epoch}: {why}, and no smaller rate helps; the stage ends with \
                 its best"
            ));
            return Ok(());
        }
        self.state.at = at;
        within.optimiser = optimiser;
        within.reduction *= 0.5;
        self.state.events.push(format!(
            "stage `{stage}`, epoch {epoch}: {why}; rolled back, the rate goes from {rate:.3e} to half"
        ));
        Ok(())
    }
}

/// Loss and gradient of some windows at coordinates.
fn evaluate(
    prepared: &mut Prepared,
    coordinates: &Coordinates,
    regularisers: &[AnyRegulariser],
    within: &StageState,
    part: &[usize],
    at: &[f64],
) -> Result<Step, TrainingError> {
    let model = coordinates.model(at);
    let Prepared { windows, engine, loss, settings } = prepared;
    // Whole epochs take the windows in their order.
    let index_of = |k: usize| part[k];
    let starts: Vec<[f64; 4]> = match &within.starts {
        Some(starts) => starts.states.clone(),
        None => part.iter().map(|&i| windows.subjects()[i].recording.initial_state()).collect(),
    };
    let loss = &*loss;
    let continuity = |k: usize| {
        let shooting = settings.shooting?;
        let next = windows.next[index_of(k)]?;
        let variance = windows.variance[index_of(k)];
        Some((next, variance.map(|v| shooting.continuity / v)))
    };
    let indexed = |k: usize, measured: &Recording, predicted: &[[f64; 4]], by: &mut [[f64; 4]]| {
        let mut value = loss.value_and_cotangents(measured, predicted, by);
        if let (Some((next, weights)), Some(end), Some(by_end)) =
            (continuity(k), predicted.last(), by.last_mut())
        {
            for c in 0..4 {
                let gap = end[c] - starts[next][c];
                value += weights[c] * gap * gap;
                by_end[c] += 2.0 * weights[c] * gap;
            }
        }
        value
    };
    let effects = coordinates.effect_parameters(at);
    let request = TrajectoryRequest {
        effects: &effects,
        part: Some(part),
        starts: Some(&starts),
        ..TrajectoryRequest::new(&model, windows)
    };
    let result = engine.evaluate(&request, &indexed, true)?;
    let failure = failure_of(&result, |k| &windows.subjects()[index_of(k)].recording.name);
    let mut by_starts = result.initial_states.clone();
    if within.starts.is_some() && failure.is_none() {
        let share = 1.0 / part.len() as f64;
        for k in 0..part.len() {
            let Some((next, weights)) = continuity(k) else { continue };
            let end = *engine.predicted(k).last().expect("windows have samples");
            for c in 0..4 {
                by_starts[next][c] -= 2.0 * share * weights[c] * (end[c] - starts[next][c]);
            }
        }
    }
    let (value, by_weights) = regularised(&model, &result, regularisers);
    let mut gradient = coordinates.gradient_of(&model, &by_weights, &result.raw);
    coordinates.write_effect_gradient(at, &result.effects, &mut gradient);
    Ok(Step { loss: value, gradient, by_starts, failure })
}

/// Adds the regularisers.
fn regularised(
    model: &NetworkJoint,
    result: &TrajectoryGradient,
    regularisers: &[AnyRegulariser],
) -> (f64, Vec<f64>) {
    let mut by_weights = result.force.clone();
    let more: f64 = regularisers.iter().map(|r| r.value_and_gradient(model, &mut by_weights)).sum();
    (result.value + more, by_weights)
}

/// Which recording could not be predicted, until when.
fn failure_of<'a>(
    result: &TrajectoryGradient,
    name_of: impl Fn(usize) -> &'a String,
) -> Option<String> {
    if let Some(f) = result.failures.first() {
        let name = name_of(f.problem);
        return Some(format!("{name} could not be predicted beyond {:.3} s", f.time_s));
    }
    let numbers = result.force.iter().chain(&result.effects);
    let numbers = numbers.chain([&result.raw.mass, &result.raw.deformation]);
    let sound = result.value.is_finite() && numbers.into_iter().all(|g| g.is_finite());
    (!sound).then(|| "loss or gradient is not finite".to_owned())
}
