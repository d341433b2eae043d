//! One epoch after another.

use super::engine::Engine;
use super::state::{EpochRow, OptimiserState, StageResult, StageState, Starts, TrainingState};
use super::windows::Windows;
use crate::coordinates::{Coordinates, NetworkJoint, Scaling};
use crate::curriculum::{Curriculum, Selection, SolveStage, Stage, StartModel};
use crate::evaluation::Subject;
use crate::identification::{Identification, identify_deformation, identify_mass};
use crate::loss::{SharedLoss, TrajectoryLoss};
use crate::optimiser::{Adam, AdamSettings, Lbfgs, OptimiserSettings};
use crate::schedule::{EarlyStop, Rate};
use crate::warm_start::{fit_deformation, random_network};
use pam_core::{Activation, AnyForce, JointModel, ModelError, ParametricForce, PhysicalParameters};
use pam_data::{DataError, MassChoice, MassOrigin, MuscleSurfaces, Recording, load_model};
use pam_solvers::input::InputError;
use std::time::Instant;
use thiserror::Error;

/// Training that cannot begin or go on.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// The curriculum asks for something that is not there.
    #[error("{0}")]
    Curriculum(String),
    /// A recording or a model file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The model cannot be built as asked.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A recording cannot drive a solve.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The solves diverge where a stage starts.
    #[error("stage `{stage}`, epoch {epoch}: {message}")]
    Diverged {
        /// The stage.
        stage: String,
        /// Its epoch.
        epoch: usize,
        /// Which recording, when, and what to do.
        message: String,
    },
}

/// Steps of the regression that tells what of the acceleration is its own: errors of it are of second
/// order in the result.
const IDENTIFICATION_STEPS: usize = 4000;

/// A curriculum at work.
#[derive(Debug)]
pub struct Trainer {
    pub(super) curriculum: Curriculum,
    pub(super) seed: u64,
    pub(super) coordinates: Coordinates,
    pub(super) state: TrainingState,
    train: Vec<Subject>,
    held_out: Vec<Subject>,
    surfaces: Option<MuscleSurfaces>,
    /// In place of those of curriculum and stages.
    loss: Option<SharedLoss>,
    pub(super) stage: Option<Prepared>,
    /// Keeps its memory from one score to the next.
    scoring: Option<Engine>,
}

/// What a stage needs and a checkpoint does not hold.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) settings: SolveStage,
    pub(super) loss: SharedLoss,
    pub(super) windows: Windows,
    pub(super) engine: Engine,
}

impl Trainer {
    /// A trainer at the start of a curriculum. `recordings` are sorted into those to train on and those
    /// held out as the curriculum says; `surfaces` give the masses as long as the model is untrained.
    ///
    /// # Errors
    /// [`TrainingError`] if a selection finds no recording, or model or masses cannot be made.
    pub fn new(
        curriculum: Curriculum,
        recordings: Vec<Recording>,
        surfaces: Option<MuscleSurfaces>,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        let start = Start::of(&curriculum, seed)?;
        Self::from_start(curriculum, &start, recordings, surfaces, seed)
    }

    /// A trainer that starts from a model of the caller's, whatever the curriculum says of it. Masses are
    /// those of its gas law where a recording gives none.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_model(
        curriculum: Curriculum,
        model: NetworkJoint,
        recordings: Vec<Recording>,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        let start = Start { model, trained: true, scaled_weights: false };
        Self::from_start(curriculum, &start, recordings, None, seed)
    }

    /// The same with a loss in place of those of the curriculum and its stages. It is no part of what a
    /// run keeps: who resumes the run gives it again.
    #[must_use]
    pub fn with_loss(mut self, loss: impl TrajectoryLoss + Send + 'static) -> Self {
        self.loss = Some(SharedLoss::new(loss));
        self.stage = None;
        self
    }

    fn from_start(
        curriculum: Curriculum,
        start: &Start,
        recordings: Vec<Recording>,
        surfaces: Option<MuscleSurfaces>,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        let (model, trained) = (&start.model, start.trained);
        let mut train = Vec::new();
        let mut held_out = Vec::new();
        for recording in recordings {
            let name = recording.name.clone();
            let trained_on = curriculum.data.train.takes(&name, false);
            let held = curriculum.data.held_out.takes(&name, trained_on) && !trained_on;
            if trained_on || held {
                let subject = subject(recording, model, trained, surfaces.as_ref())?;
                if trained_on { train.push(subject) } else { held_out.push(subject) }
            }
        }
        if train.is_empty() {
            return Err(TrainingError::Curriculum(
                "data.train selects none of the recordings; select \"all\", or give their names"
                    .into(),
            ));
        }
        for stage in &curriculum.stages {
            if select(&train, stage.recordings()).is_empty() {
                return Err(TrainingError::Curriculum(format!(
                    "stage `{}` selects none of the training recordings",
                    stage.name()
                )));
            }
        }
        let settings = &curriculum.coordinates;
        let scaling = if settings.scaled { Scaling::of_data(&train) } else { Scaling::none() };
        let coordinates =
            Coordinates::new(model.clone(), scaling, settings.physical, settings.frozen);
        let mut at = coordinates.of(model);
        if start.scaled_weights {
            let weights = model.force.parameters();
            at[..weights.len()].copy_from_slice(&weights);
        }
        let state = TrainingState {
            stage: 0,
            epochs: 0,
            at,
            scaling,
            within: None,
            results: Vec::new(),
            events: Vec::new(),
        };
        Ok(Self {
            curriculum,
            seed,
            coordinates,
            state,
            train,
            held_out,
            surfaces,
            loss: None,
            stage: None,
            scoring: None,
        })
    }

    /// Goes on from a state that was saved.
    ///
    /// # Errors
    /// [`TrainingError::Curriculum`] if it belongs to another network or curriculum.
    pub fn resume(&mut self, state: TrainingState) -> Result<(), TrainingError> {
        if state.at.len() != self.coordinates.len() || state.stage > self.curriculum.stages.len() {
            return Err(TrainingError::Curriculum(
                "the checkpoint belongs to another network or curriculum".into(),
            ));
        }
        let settings = &self.curriculum.coordinates;
        let template = self.coordinates.model(&state.at);
        self.coordinates =
            Coordinates::new(template, state.scaling, settings.physical, settings.frozen);
        self.state = state;
        self.stage = None;
        Ok(())
    }

    /// The state, for a checkpoint.
    #[must_use]
    pub fn state(&self) -> &TrainingState {
        &self.state
    }

    /// The curriculum.
    #[must_use]
    pub fn curriculum(&self) -> &Curriculum {
        &self.curriculum
    }

    /// Names of the recordings that are trained on.
    #[must_use]
    pub fn trained_on(&self) -> Vec<String> {
        self.train.iter().map(|s| s.recording.name.clone()).collect()
    }

    /// What tells one set of training recordings from another.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        // FNV-1a over names and the bits of displacements and forces.
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |word: u64| hash = (hash ^ word).wrapping_mul(0x0100_0000_01b3);
        for s in &self.train {
            let r = &s.recording;
            r.name.bytes().for_each(|b| add(u64::from(b)));
            r.displacement_mm.iter().chain(&r.force_mn).for_each(|v| add(v.to_bits()));
        }
        format!("{hash:016x}")
    }

    /// Number of recordings that are held out.
    #[must_use]
    pub fn held_out_len(&self) -> usize {
        self.held_out.len()
    }

    /// Whether all stages are done.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.state.stage >= self.curriculum.stages.len()
    }

    /// The model as it is now, without auxiliary damping.
    #[must_use]
    pub fn model(&self) -> NetworkJoint {
        let mut model = self.coordinates.model(&self.state.at);
        model.auxiliary_damping_kg_s = 0.0;
        model
    }

    /// What the training recordings say of the physical parameters of the model as it is now. Takes
    /// some seconds.
    ///
    /// # Errors
    /// [`TrainingError::Data`] if masses cannot be made.
    pub fn identify(&self) -> Result<Identification, TrainingError> {
        let model = self.model();
        let mut subjects = self.train.clone();
        update_masses(&mut subjects, &model, self.surfaces.as_ref())?;
        let stages = self.curriculum.stages.iter().rev();
        let matching = stages.filter_map(|s| match s {
            Stage::Derivatives(s) => Some(s.matching),
            _ => None,
        });
        let mut matching = { matching }.next().unwrap_or_default();
        matching.steps = matching.steps.min(IDENTIFICATION_STEPS);
        let nu = model.physical().deformation;
        Ok(Identification {
            mass: identify_mass(&model, &subjects, &matching, self.seed),
            deformation: identify_deformation(&subjects, &model.geometry, nu),
        })
    }

    /// Does the next epoch, or the next stage that has none. `None` when all is done.
    ///
    /// # Errors
    /// [`TrainingError`]; the state is that before the epoch.
    pub fn advance(&mut self) -> Result<Option<EpochRow>, TrainingError> {
        let Some(stage) = self.curriculum.stages.get(self.state.stage).cloned() else {
            return Ok(None);
        };
        let begun = Instant::now();
        match stage {
            Stage::Gas(s) => {
                let subjects = select(&self.train, s.recordings.as_ref());
                let model = self.model();
                let start = model.physical().deformation;
                let fitted = fit_deformation(&subjects, &model.geometry, start);
                let mut fitted_model = model;
                let physical = PhysicalParameters {
                    deformation: fitted.deformation,
                    ..fitted_model.physical()
                };
                fitted_model.raw = physical.to_raw();
                self.state.at = self.with_network_kept(&fitted_model);
                self.regressed(&s.name, begun, fitted.rms_kpa, subjects).map(Some)
            }
            Stage::Derivatives(s) => {
                self.coordinates.set_auxiliary_damping(0.0);
                let subjects = self.selected(s.recordings.as_ref())?;
                let matched = s.matching.run(
                    &self.coordinates,
                    &self.state.at,
                    &subjects,
                    self.seed,
                    &|_, _| {},
                );
                self.state.at = matched.at;
                self.regressed(&s.name, begun, matched.rms_n, subjects).map(Some)
            }
            Stage::Solve(s) => {
                self.enter(&s)?;
                let mut row = self.epoch(begun)?;
                if self.curriculum.score_every.is_some_and(|n| row.epoch.is_multiple_of(n)) {
                    let scores = self.score_held_out()?;
                    row.r2_held_out =
                        (!self.held_out.is_empty()).then(|| scores.map(|v| v.unwrap_or(f64::NAN)));
                }
                let within = self.state.within.as_ref().expect("entered");
                if within.epoch >= s.epochs || within.stopped {
                    self.leave(&s)?;
                }
                Ok(Some(row))
            }
        }
    }

    /// Coordinates of a model whose network stays as it is, to the bit.
    fn with_network_kept(&self, model: &NetworkJoint) -> Vec<f64> {
        let weights = self.state.at.len() - crate::coordinates::PHYSICAL;
        let mut at = self.coordinates.of(model);
        at[..weights].copy_from_slice(&self.state.at[..weights]);
        at
    }

    /// The recordings of a selection with masses by the gas law of the model that the stage starts from
    /// (files and surfaces win).
    fn selected(&self, selection: Option<&Selection>) -> Result<Vec<Subject>, TrainingError> {
        let at = self.state.within.as_ref().map_or(&self.state.at, |w| &w.start);
        let mut subjects = select(&self.train, selection);
        update_masses(&mut subjects, &self.coordinates.model(at), self.surfaces.as_ref())?;
        Ok(subjects)
    }

    /// Makes ready what a stage needs.
    fn enter(&mut self, s: &SolveStage) -> Result<(), TrainingError> {
        self.coordinates.set_auxiliary_damping(s.auxiliary_damping);
        if self.stage.is_none() {
            let subjects = self.selected(s.recordings.as_ref())?;
            let solver = s.solver.as_ref().unwrap_or(&self.curriculum.solver);
            self.stage = Some(Prepared {
                loss: self.loss.clone().unwrap_or_else(|| {
                    SharedLoss::new(s.loss.as_ref().unwrap_or(&self.curriculum.loss).clone())
                }),
                windows: Windows::of(&subjects, s.horizon_s),
                engine: Engine::new(
                    solver.settings_for(&self.coordinates.model(&self.state.at).force)?,
                    solver.precision,
                    solver.gradient_choice()?,
                ),
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
                optimiser: Adam::new(AdamSettings::default(), 4 * windows.subjects.len()),
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
    fn leave(&mut self, s: &SolveStage) -> Result<(), TrainingError> {
        let subjects = select(&self.train, s.recordings.as_ref());
        let within = self.state.within.take().expect("a running stage");
        self.stage = None;
        let (loss, at) = within.best.map_or((f64::NAN, self.state.at.clone()), |b| (b.loss, b.at));
        self.state.at = at;
        self.finish(
            StageResult {
                name: s.name.clone(),
                epochs: within.epoch,
                seconds: within.seconds,
                first_loss: within.first_loss,
                best_loss: loss,
                r2_train: [None; 4],
                r2_held_out: [None; 4],
            },
            subjects,
        )
    }

    /// Ends a stage that is a regression, and counts it as an epoch.
    fn regressed(
        &mut self,
        name: &str,
        begun: Instant,
        residual: f64,
        subjects: Vec<Subject>,
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
        self.finish(result, subjects)?;
        Ok(row)
    }

    /// Scores and notes what a stage reached, and goes to the next one.
    fn finish(
        &mut self,
        mut result: StageResult,
        mut subjects: Vec<Subject>,
    ) -> Result<(), TrainingError> {
        let solver = &self.curriculum.solver;
        let model = self.coordinates.model(&self.state.at);
        let mut engine = Engine::new(solver.settings_for(&model.force)?, solver.precision, None);
        // Pressures alone say nothing of the force.
        let predicts = !matches!(self.curriculum.stages[self.state.stage], Stage::Gas(_));
        if predicts {
            update_masses(&mut subjects, &model, self.surfaces.as_ref())?;
            result.r2_train = engine.mean_r2(&model, &subjects)?;
            result.r2_held_out = self.score_held_out()?;
        }
        self.state.results.push(result);
        self.state.stage += 1;
        Ok(())
    }

    /// Mean R² over the held-out recordings with the coordinates as they are.
    fn score_held_out(&mut self) -> Result<[Option<f64>; 4], TrainingError> {
        let solver = &self.curriculum.solver;
        let model = self.coordinates.model(&self.state.at);
        let engine = Engine::new(solver.settings_for(&model.force)?, solver.precision, None);
        let engine = self.scoring.get_or_insert(engine);
        update_masses(&mut self.held_out, &model, self.surfaces.as_ref())?;
        Ok(engine.mean_r2(&model, &self.held_out)?)
    }
}

/// The recordings of a selection.
fn select(subjects: &[Subject], selection: Option<&Selection>) -> Vec<Subject> {
    let takes =
        |s: &&Subject| selection.is_none_or(|selection| selection.takes(&s.recording.name, true));
    subjects.iter().filter(takes).cloned().collect()
}

/// Computes anew the masses that come from the gas law.
fn update_masses(
    subjects: &mut [Subject],
    model: &NetworkJoint,
    surfaces: Option<&MuscleSurfaces>,
) -> Result<(), TrainingError> {
    for s in subjects.iter_mut().filter(|s| s.origin == MassOrigin::GasLaw) {
        (s.masses, s.origin) =
            pam_data::resolve_masses(&s.recording, model, true, MassChoice::Auto, surfaces)?;
    }
    Ok(())
}

/// A recording with its masses.
fn subject(
    recording: Recording,
    model: &NetworkJoint,
    trained: bool,
    surfaces: Option<&MuscleSurfaces>,
) -> Result<Subject, TrainingError> {
    let (masses, origin) =
        pam_data::resolve_masses(&recording, model, trained, MassChoice::Auto, surfaces)?;
    Ok(Subject { recording, masses, origin })
}

/// The model that training starts from.
struct Start {
    model: NetworkJoint,
    /// Whether its gas law is worth more than surfaces.
    trained: bool,
    /// Whether its weights are those between scaled inputs and a scaled output, as random ones are.
    scaled_weights: bool,
}

impl Start {
    fn of(curriculum: &Curriculum, seed: u64) -> Result<Self, TrainingError> {
        let settings = &curriculum.model;
        let path = match &settings.start {
            StartModel::Random => {
                let activation = Activation::from_name(&settings.activation)?;
                let force =
                    random_network(&settings.hidden, activation, settings.initialisation, seed)?;
                let model = JointModel::datasheet(force);
                return Ok(Self { model, trained: false, scaled_weights: true });
            }
            StartModel::File(path) => path,
        };
        let saved = load_model(path)?;
        if !saved.info.effects.is_empty() {
            return Err(TrainingError::Curriculum(format!(
                "{} is extended by effects, which training does not move; `pam convert --plain` makes a \
                 plain model of it",
                path.display()
            )));
        }
        let AnyForce::Network(force) = &saved.model.force else {
            return Err(TrainingError::Curriculum(format!(
                "{} holds no network to train",
                path.display()
            )));
        };
        let model = saved.model.map(|v| v, |_| force.clone());
        Ok(Self { model, trained: saved.info.trained, scaled_weights: false })
    }
}
