//! The stages of a curriculum: entered, left and scored.

use super::beginning::{select, update_masses};
use super::effects;
use super::error::TrainingError;
use super::scores::mean_r2;
use super::state::{EpochRow, OptimiserState, StageResult, StageState, Starts};
use super::trainer::{Prepared, Trainer};
use crate::coordinates::{EffectCoordinate, PHYSICAL};
use crate::curriculum::{Selection, SolveStage, Stage};
use crate::optimiser::{Adam, AdamSettings, Lbfgs, OptimiserSettings};
use crate::schedule::{EarlyStop, Rate};
use pam_data::Subject;
use pam_effects::engine::{EngineChoice, choose};
use pam_trajectory::engine::{GradientChoice, NetworkJoint, TrajectoryEngine};
use pam_trajectory::loss::SharedLoss;
use pam_trajectory::windows::Windows;
use std::time::Instant;

impl Trainer {
    /// Coordinates of a model whose network stays unchanged, bit for bit.
    pub(super) fn with_network_kept(&self, model: &NetworkJoint) -> Vec<f64> {
        let weights = self.coordinates.weights_len();
        let behind = weights + PHYSICAL;
        let mut at = self.coordinates.of(model);
        at[..weights].copy_from_slice(&self.state.at[..weights]);
        at[behind..].copy_from_slice(&self.state.at[behind..]);
        at
    }

    /// Finds the units of the effects' coordinates, once, with the model as it is.
    fn find_units(&mut self, subjects: &[Subject]) -> Result<(), TrainingError> {
        if !self.state.units.is_empty() || self.coordinates.effects().is_empty() {
            return Ok(());
        }
        let model = self.coordinates.model(&self.state.at);
        let active = self.effects();
        let values = self.coordinates.effect_parameters(&self.state.at);
        let rate = self.curriculum.coordinates.effect_rate;
        let mut units = if self.coordinates.frozen().effects {
            vec![1.0; values.len()]
        } else {
            effects::units(&active, &model, subjects)?
        };
        for (unit, c) in units.iter_mut().zip(self.coordinates.effects()) {
            *unit = rate * unit.min(c.largest_unit());
        }
        let coordinates = EffectCoordinate::all_of(&self.effects, &units);
        let behind = self.state.at.len() - values.len();
        for ((at, value), c) in self.state.at[behind..].iter_mut().zip(values).zip(&coordinates) {
            *at = c.at(value);
        }
        self.coordinates = self.coordinates.clone().with_effects(coordinates);
        self.state.units = units;
        Ok(())
    }

    /// The engine for the model.
    fn engine(&self, choice: &EngineChoice) -> Result<Box<dyn TrajectoryEngine>, TrainingError> {
        let model = self.coordinates.model(&self.state.at);
        Ok(choose(&model.force, &self.effects, choice)?)
    }

    /// The engine for scores, which needs no gradients.
    fn scoring_engine(&self) -> Result<Box<dyn TrajectoryEngine>, TrainingError> {
        let choice = self.curriculum.solver.engine_choice()?;
        self.engine(&EngineChoice { gradient: GradientChoice::Adjoint, ..choice })
    }

    /// The recordings of a selection with masses by the gas law of the model that the stage starts from
    /// (files and surfaces win).
    pub(super) fn selected(
        &self,
        selection: Option<&Selection>,
    ) -> Result<Vec<Subject>, TrainingError> {
        let at = self.state.within.as_ref().map_or(&self.state.at, |w| &w.start);
        let mut subjects: Vec<Subject> = select(&self.train, selection).cloned().collect();
        update_masses(&mut subjects, &self.coordinates.model(at), self.surfaces.as_ref())?;
        Ok(subjects)
    }

    /// Makes ready what a stage needs.
    pub(super) fn enter(&mut self, s: &SolveStage) -> Result<(), TrainingError> {
        self.coordinates.set_auxiliary_damping(s.auxiliary_damping);
        if self.stage.is_none() {
            let subjects = self.selected(s.recordings.as_ref())?;
            self.find_units(&subjects)?;
            let solver = s.solver.as_ref().unwrap_or(&self.curriculum.solver);
            self.stage = Some(Prepared {
                loss: self.loss.clone().unwrap_or_else(|| {
                    SharedLoss::new(s.loss.as_ref().unwrap_or(&self.curriculum.loss).clone())
                }),
                windows: Windows::of(subjects, s.horizon_s),
                engine: self.engine(&solver.engine_choice()?)?,
                settings: s.clone(),
            });
        }
        if self.state.within.is_none() {
            let len = self.coordinates.len();
            let settings = s.optimiser.as_ref().unwrap_or(&self.curriculum.optimiser);
            let optimiser = match (settings, settings.adam()) {
                (OptimiserSettings::Lbfgs(l), _) => OptimiserState::Lbfgs(Lbfgs::new(*l, len)),
                (_, adam) => OptimiserState::Adam(Adam::new(adam.unwrap_or_default(), len)),
            };
            let windows = &self.stage.as_ref().expect("just made").windows;
            let starts = s.shooting.map(|_| Starts {
                states: windows.measured_starts(),
                optimiser: Adam::new(AdamSettings::default(), 4 * windows.subjects().len()),
            });
            let schedule = s.schedule.as_ref().unwrap_or(&self.curriculum.schedule);
            self.state.within = Some(StageState {
                epoch: 0,
                start: self.state.at.clone(),
                optimiser,
                rate: Rate::new(*schedule),
                stop: s.patience.map(EarlyStop::new),
                stopped: false,
                reduction: 1.0,
                sound: None,
                best: None,
                starts,
                first_loss: None,
                seconds: 0.0,
            });
        }
        Ok(())
    }

    /// Ends a stage with its best coordinates.
    pub(super) fn leave(&mut self, s: &SolveStage) -> Result<(), TrainingError> {
        let within = self.state.within.take().expect("a running stage");
        self.stage = None;
        let (loss, at) = within.best.map_or((f64::NAN, self.state.at.clone()), |b| (b.loss, b.at));
        self.state.at = at;
        self.finish(StageResult {
            name: s.name.clone(),
            epochs: within.epoch,
            seconds: within.seconds,
            first_loss: within.first_loss,
            best_loss: loss,
            r2_train: [None; 4],
            r2_held_out: [None; 4],
        })
    }

    /// Ends a stage that is a regression, and counts it as an epoch.
    pub(super) fn regressed(
        &mut self,
        name: &str,
        begun: Instant,
        residual: f64,
    ) -> Result<EpochRow, TrainingError> {
        let physical = self.model().physical();
        self.state.epochs += 1;
        let row = EpochRow {
            stage: self.state.stage,
            epoch: 1,
            total_epoch: self.state.epochs,
            loss: residual,
            rate: 0.0,
            gradient_norm: 0.0,
            mass_kg: physical.mass_kg,
            deformation: physical.deformation,
            effects: self.coordinates.effect_parameters(&self.state.at),
            r2_held_out: None,
            seconds: begun.elapsed().as_secs_f64(),
        };
        let result = StageResult {
            name: name.to_owned(),
            epochs: 1,
            seconds: row.seconds,
            first_loss: None,
            best_loss: residual,
            r2_train: [None; 4],
            r2_held_out: [None; 4],
        };
        self.finish(result)?;
        Ok(row)
    }

    /// Scores and notes what a stage reached, and goes to the next one.
    fn finish(&mut self, mut result: StageResult) -> Result<(), TrainingError> {
        let stage = &self.curriculum.stages[self.state.stage];
        // Pressures alone say nothing of the force.
        if !matches!(stage, Stage::Gas(_)) {
            let mut engine = self.scoring.take().map_or_else(|| self.scoring_engine(), Ok)?;
            let recordings = select(&self.train, stage.recordings()).cloned();
            result.r2_train = self.mean_r2(&mut *engine, recordings)?;
            self.scoring = Some(engine);
            result.r2_held_out = self.score_held_out()?;
        }
        self.state.results.push(result);
        self.state.stage += 1;
        Ok(())
    }

    /// Mean R² over the held-out recordings with the coordinates as they are.
    pub(super) fn score_held_out(&mut self) -> Result<[Option<f64>; 4], TrainingError> {
        let mut engine = self.scoring.take().map_or_else(|| self.scoring_engine(), Ok)?;
        let scores = self.mean_r2(&mut *engine, self.held_out.subjects())?;
        self.scoring = Some(engine);
        Ok(scores)
    }

    fn mean_r2(
        &self,
        engine: &mut dyn TrajectoryEngine,
        recordings: impl Iterator<Item = Subject>,
    ) -> Result<[Option<f64>; 4], TrainingError> {
        let model = self.coordinates.model(&self.state.at);
        let effects = self.coordinates.effect_parameters(&self.state.at);
        mean_r2(engine, (&model, &effects), self.surfaces.as_ref(), recordings)
    }
}
