//! One epoch after another.

use super::beginning::{Start, select, subject, update_masses};
use super::effects;
use super::error::TrainingError;
use super::held_out::HeldOut;
use super::state::{EpochRow, TrainingState};
use crate::coordinates::{Coordinates, EffectCoordinate, Scaling};
use crate::curriculum::{Curriculum, SolveStage, Stage, StartModel};
use crate::identification::{Identification, identify_deformation, identify_mass};
use crate::warm_start::fit_deformation;
use pam_core::{ParametricForce, PhysicalParameters};
use pam_data::fingerprint::fingerprint;
use pam_data::{MuscleSurfaces, Recording, Subject};
use pam_effects::ActiveEffect;
use pam_numerics::ContentHash;
use pam_trajectory::engine::{GradientChoice, NetworkJoint, TrajectoryEngine};
use pam_trajectory::loss::{SharedLoss, TrajectoryLoss};
use pam_trajectory::windows::Windows;
use std::sync::OnceLock;
use std::time::Instant;

/// Steps of the regression of the acceleration on the inputs of the force: its errors are of second order in the
/// result.
const IDENTIFICATION_STEPS: usize = 4000;

/// A curriculum at work.
#[derive(Debug)]
pub struct Trainer {
    pub(super) curriculum: Curriculum,
    pub(super) seed: u64,
    pub(super) coordinates: Coordinates,
    pub(super) state: TrainingState,
    pub(super) train: Vec<Subject>,
    pub(super) held_out: HeldOut,
    pub(super) surfaces: Option<MuscleSurfaces>,
    /// As they start.
    pub(super) effects: Vec<ActiveEffect>,
    /// In place of those of curriculum and stages.
    pub(super) loss: Option<SharedLoss>,
    pub(super) stage: Option<Prepared>,
    /// Keeps its memory from one score to the next.
    pub(super) scoring: Option<Box<dyn TrajectoryEngine>>,
    fingerprint: OnceLock<String>,
}

/// A running stage, without what a checkpoint holds.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) settings: SolveStage,
    pub(super) loss: SharedLoss,
    pub(super) windows: Windows,
    pub(super) engine: Box<dyn TrajectoryEngine>,
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
        Self::extended(curriculum, recordings, surfaces, Vec::new(), seed)
    }

    /// As [`new`](Self::new), of a model with effects, for example those that the curriculum names
    /// ([`effects_of`](super::effects_of)). Each parameter stays in its
    /// [range](pam_effects::effects::ParameterInfo::range) and is moved by its logarithm where it is a scale;
    /// switches stay as they are. Stages through the solver train all numbers together; regressions train the same
    /// as without effects.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`TrainingError::Effect`] for a value outside its range or an effect that is there
    /// twice; [`TrainingError::Curriculum`] if the curriculum names effects and none are given, or a gradient
    /// method that has none of them.
    pub fn extended(
        mut curriculum: Curriculum,
        recordings: Vec<Recording>,
        surfaces: Option<MuscleSurfaces>,
        effects: Vec<ActiveEffect>,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        effects::check(&effects)?;
        // The run keeps what defines them, so that it goes on in a process that was not told.
        for record in &mut curriculum.model.effects {
            let own = effects.iter().find(|a| a.effect.info().id == record.effect);
            record.definition = own.and_then(|a| a.effect.definition()).map(str::to_owned);
        }
        let start = Start::of(&curriculum, !effects.is_empty(), seed)?;
        if !effects.is_empty() {
            let solvers = curriculum.stages.iter().filter_map(|stage| match stage {
                Stage::Solve(s) => s.solver.as_ref(),
                _ => None,
            });
            for solver in solvers.chain([&curriculum.solver]) {
                let choice = solver.gradient_choice()?;
                if choice != GradientChoice::Adjoint {
                    return Err(TrainingError::Curriculum(format!(
                        "solver.gradient {}: a model with effects has the adjoint of its own steps; take auto",
                        choice.name()
                    )));
                }
            }
        }
        Self::from_start(curriculum, &start, recordings, surfaces, effects, seed)
    }

    /// A trainer that starts from this model in place of that of the curriculum. Masses are
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
        Self::from_start(curriculum, &start, recordings, None, Vec::new(), seed)
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
        effects: Vec<ActiveEffect>,
        seed: u64,
    ) -> Result<Self, TrainingError> {
        let (model, trained) = (&start.model, start.trained);
        let names: Vec<String> = recordings.iter().map(|r| r.name.clone()).collect();
        let split = curriculum.data.split(recordings);
        let subjects = |recordings: Vec<Recording>| -> Result<Vec<Subject>, TrainingError> {
            recordings.into_iter().map(|r| subject(r, model, trained, surfaces.as_ref())).collect()
        };
        let (train, held_out) = (subjects(split.train)?, subjects(split.held_out)?);
        if train.is_empty() {
            return Err(TrainingError::Curriculum(format!(
                "data.train selects none of the recordings ({}); select \"all\", or give names or patterns",
                names.join(", ")
            )));
        }
        for stage in &curriculum.stages {
            if select(&train, stage.recordings()).next().is_none() {
                return Err(TrainingError::Curriculum(format!(
                    "stage `{}` selects none of the training recordings",
                    stage.name()
                )));
            }
        }
        let settings = &curriculum.coordinates;
        let scaling = if settings.scaled { Scaling::of_data(&train) } else { Scaling::none() };
        let coordinates =
            Coordinates::new(model.clone(), scaling, settings.physical, settings.frozen)
                .with_effects(EffectCoordinate::all_of(&effects, &[]));
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
            units: Vec::new(),
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
            held_out: HeldOut::of(held_out),
            surfaces,
            effects,
            loss: None,
            stage: None,
            scoring: None,
            fingerprint: OnceLock::new(),
        })
    }

    /// Goes on from a state that was saved.
    ///
    /// # Errors
    /// [`TrainingError::Curriculum`] if it belongs to another network or curriculum.
    pub fn resume(&mut self, state: TrainingState) -> Result<(), TrainingError> {
        if !state.fits(self.coordinates.len(), self.curriculum.stages.len()) {
            return Err(TrainingError::Curriculum(
                "the checkpoint belongs to another network or curriculum".into(),
            ));
        }
        let settings = &self.curriculum.coordinates;
        let template = self.coordinates.model(&state.at);
        self.coordinates =
            Coordinates::new(template, state.scaling, settings.physical, settings.frozen)
                .with_effects(EffectCoordinate::all_of(&self.effects, &state.units));
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

    /// The [fingerprint](pam_data::fingerprint) of all recordings, including the held-out ones.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        // The air masses are left out because they may change during training. Everything else is constant.
        let of_both = || {
            let trained_on = fingerprint(self.train.iter().map(|s| &s.recording));
            format!("{trained_on} {}", self.held_out.fingerprint())
        };
        self.fingerprint.get_or_init(of_both).clone()
    }

    /// A hash of everything else that decides how training goes on: curriculum, model file to start from, mass
    /// surfaces and effects.
    ///
    /// # Errors
    /// [`TrainingError::Data`] if the model file cannot be read.
    pub fn settings_fingerprint(&self) -> Result<String, TrainingError> {
        let mut hash = ContentHash::default();
        hash.text(&self.curriculum.to_toml());
        if let StartModel::File(path) = &self.curriculum.model.start {
            hash.bytes(&pam_data::read_limit::read(path)?);
        }
        // The text of all coefficients.
        hash.text(&format!("{:?}", self.surfaces));
        for active in &self.effects {
            hash.text(active.effect.info().id);
            hash.numbers(&active.values);
        }
        Ok(hash.hex())
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

    /// The model's effects as they are now.
    #[must_use]
    pub fn effects(&self) -> Vec<ActiveEffect> {
        let parameters = self.coordinates.effect_parameters(&self.state.at);
        ActiveEffect::with_parameters(&self.effects, &parameters)
    }

    /// Names of the parameters of the effects, `coulomb_friction.force_n`, and their values now.
    #[must_use]
    pub fn effect_values(&self) -> Vec<(String, f64)> {
        let names = effects::parameter_names(&self.effects).into_iter();
        names.zip(self.coordinates.effect_parameters(&self.state.at)).collect()
    }

    /// Standard errors of the physical parameters of the model as it is now, from the training recordings. Takes
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
                let subjects: Vec<Subject> =
                    select(&self.train, s.recordings.as_ref()).cloned().collect();
                let model = self.model();
                let start = model.physical().deformation;
                let fitted = fit_deformation(&subjects, &model.geometry, start);
                drop(subjects);
                let mut fitted_model = model;
                let physical = PhysicalParameters {
                    deformation: fitted.deformation,
                    ..fitted_model.physical()
                };
                fitted_model.raw = physical.to_raw();
                self.state.at = self.with_network_kept(&fitted_model);
                self.regressed(&s.name, begun, fitted.rms_kpa).map(Some)
            }
            Stage::Derivatives(s) => {
                self.coordinates.set_auxiliary_damping(0.0);
                let subjects = self.selected(s.recordings.as_ref())?;
                let matched =
                    s.matching.run(&self.coordinates, &self.state.at, &subjects, self.seed);
                drop(subjects);
                if !matched.at.iter().all(|v| v.is_finite()) {
                    return Err(TrainingError::Diverged {
                        stage: s.name,
                        epoch: 0,
                        message: "the regression gives no finite numbers: the forces or accelerations of the \
                                  recordings are beyond any joint; check their units with `pam inspect`"
                            .into(),
                    });
                }
                self.state.at = matched.at;
                self.regressed(&s.name, begun, matched.rms_n).map(Some)
            }
            Stage::Solve(s) => {
                self.enter(&s)?;
                let mut row = self.epoch(begun)?;
                if self.curriculum.score_every.is_some_and(|n| row.epoch.is_multiple_of(n)) {
                    let scores = self.score_held_out()?;
                    row.r2_held_out =
                        (self.held_out.len() > 0).then(|| scores.map(|v| v.unwrap_or(f64::NAN)));
                }
                let within = self.state.within.as_ref().expect("entered");
                if within.epoch >= s.epochs || within.stopped {
                    self.leave(&s)?;
                }
                Ok(Some(row))
            }
        }
    }
}
