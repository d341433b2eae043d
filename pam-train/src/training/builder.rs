//! A training in a few lines.

use super::error::TrainingError;
use super::folder::{RunFolder, RunSettings, TrainedRun, train_into};
use super::state::EpochRow;
use super::trainer::Trainer;
use crate::curriculum::{
    Curriculum, CurriculumError, Selection, SelectionSet, SolverChoice, Stage,
};
use pam_core::activation::ChosenActivation;
use pam_core::{Activation, ModelError};
use pam_data::{MuscleSurfaces, Recording};
use pam_trajectory::engine::NetworkJoint;
use pam_trajectory::loss::{SharedLoss, TrajectoryLoss};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A training of the joint, described and then run. Unset options come from the recommended
/// curriculum, or from the published one with [`published`](Self::published): 96×96 network, its loss,
/// datasheet parameters.
///
/// ```
/// use num_dual::DualNum;
/// use pam_core::{ForceInput, JointModel, SpringDamper};
/// use pam_data::Recording;
/// use pam_trajectory::loss::{SampleErrors, pointwise};
/// use pam_train::training::Training;
/// use pam_trajectory::{Predictor, SolverSettings};
///
/// // Two recordings, made by a spring and a damper; those of a rig are read with `read_recordings`.
/// let plant = JointModel::datasheet(SpringDamper::constant(150e3, 6500.0));
/// let masses = plant.gas_law_masses(0.0, [412.0, 412.0]);
/// let made = |hz: f64| {
///     let time_s = (0..500).map(|k| 2e-3 * f64::from(k)).collect();
///     let sine = move |t: f64| 100e3 * (std::f64::consts::TAU * hz * t).sin(); // mN
///     let command = Recording::at_rest(&format!("{hz} Hz"), time_s, [412.0, 412.0]).with_force(sine);
///     plant.predict(&command, masses, &SolverSettings::default()).map(|run| run.to_recording(&command, masses))
/// };
///
/// let trained = Training::new([made(1.0)?, made(2.0)?])
///     .with_held_out([made(1.5)?])
///     .with_hidden([16])
///     .with_loss(pointwise(|[x, v, _, _]: SampleErrors| x.cosh().ln() + v * v * 1e-2))
///     .with_setting("stage.1.matching.steps=300")
///     .with_epochs(10)
///     .with_seed(1)
///     .run()?;
/// let last = trained.run.results.last().expect("three stages");
/// assert!(last.r2_held_out[0].expect("one is held out") > 0.9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
#[must_use = "a training does nothing until it is run"]
pub struct Training {
    recordings: Vec<Recording>,
    held_out: Vec<Recording>,
    surfaces: Option<MuscleSurfaces>,
    curriculum: Curriculum,
    settings: Vec<String>,
    model: Option<NetworkJoint>,
    loss: Option<SharedLoss>,
    activation: Option<Result<Activation, ModelError>>,
    seed: u64,
}

/// The result of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The model.
    pub model: NetworkJoint,
    /// Stages, epochs and events.
    pub run: TrainedRun,
}

fn built_in(name: &str) -> Curriculum {
    Curriculum::open(name, &[]).expect("a test reads every curriculum of the crate")
}

impl Training {
    /// A training on all of these recordings by the curriculum `recommended`, seed 0.
    ///
    /// # Panics
    /// Never: the curriculum comes with the crate.
    pub fn new(recordings: impl IntoIterator<Item = Recording>) -> Self {
        Self {
            recordings: recordings.into_iter().collect(),
            held_out: Vec::new(),
            surfaces: None,
            curriculum: built_in("recommended"),
            settings: Vec::new(),
            model: None,
            loss: None,
            activation: None,
            seed: 0,
        }
    }

    /// A training by the 16 stages of the paper, which name their recordings (`nn_4545`, …).
    ///
    /// # Panics
    /// Never: the curriculum comes with the crate.
    pub fn published(recordings: impl IntoIterator<Item = Recording>) -> Self {
        Self::new(recordings).with_curriculum(built_in("paper"))
    }

    /// The same by another curriculum. Its selection of training and held-out recordings gives way to
    /// what this training is given; those of its stages hold.
    pub fn with_curriculum(mut self, curriculum: Curriculum) -> Self {
        self.curriculum = curriculum;
        self
    }

    /// The same with recordings that are scored and never trained on.
    pub fn with_held_out(mut self, recordings: impl IntoIterator<Item = Recording>) -> Self {
        self.held_out = recordings.into_iter().collect();
        self
    }

    /// The same with surfaces that give the masses while the model is untrained.
    pub fn with_surfaces(mut self, surfaces: MuscleSurfaces) -> Self {
        self.surfaces = Some(surfaces);
        self
    }

    /// The same from a model that is there, in place of random weights.
    pub fn with_model(mut self, model: NetworkJoint) -> Self {
        self.model = Some(model);
        self
    }

    /// The same with hidden layers of these widths.
    pub fn with_hidden(mut self, widths: impl IntoIterator<Item = usize>) -> Self {
        self.curriculum.model.hidden = widths.into_iter().collect();
        self
    }

    /// The same with this activation: a name ([`Activation::names`]), or a custom type with
    /// [`NamedActivation`](pam_core::activation::NamedActivation), which is known by its name from then on, so that the
    /// trained model can be saved and loaded.
    ///
    /// ```
    /// # use pam_core::activation::NamedActivation;
    /// # use pam_core::{ActivationFunction, Scalar};
    /// # use pam_train::training::Training;
    /// # use serde::{Deserialize, Serialize};
    /// /// The square of a ReLU.
    /// #[derive(Debug, Clone, Copy, Serialize, Deserialize)]
    /// struct SquaredRelu;
    ///
    /// impl ActivationFunction for SquaredRelu {
    ///     fn value<S: Scalar>(&self, z: S) -> S {
    ///         if z.real() > 0.0 { z * z } else { S::zero() }
    ///     }
    /// }
    /// impl NamedActivation for SquaredRelu {
    ///     const NAME: &'static str = "squared_relu";
    /// }
    ///
    /// let by_type = Training::new([]).with_activation(SquaredRelu);
    /// let by_name = Training::new([]).with_activation("tanh");
    /// # let _ = (by_type, by_name);
    /// ```
    ///
    /// [`trainer`](Self::trainer) reports an unknown name, and an activation whose name another one has.
    pub fn with_activation(mut self, activation: impl ChosenActivation) -> Self {
        match activation.choose() {
            Ok(activation) => {
                self.curriculum.model.activation = activation.name().to_owned();
                self.activation = Some(Ok(activation));
            }
            Err(e) => self.activation = Some(Err(e)),
        }
        self
    }

    /// The same with a loss that is a closure `|measured, predicted, cotangents|`, in every stage: it returns the loss of
    /// the predicted rows `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa), one for each sample of the measured recording, and
    /// writes its derivative by each of them to the cotangents.
    pub fn with_loss_fn(
        self,
        loss: impl Fn(&Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        self.with_loss(loss)
    }

    /// The same with this loss in every stage: a type with [`TrajectoryLoss`] or a function of the errors of one sample,
    /// [`pointwise`](pam_trajectory::loss::pointwise).
    pub fn with_loss(mut self, loss: impl TrajectoryLoss + Send + 'static) -> Self {
        self.loss = Some(SharedLoss::new(loss));
        self
    }

    /// The same with this solver in every stage.
    pub fn with_solver(mut self, solver: SolverChoice) -> Self {
        self.curriculum.solver = solver;
        self.solve_stages(|s| s.solver = None)
    }

    /// The same with this learning rate in every stage that is trained through the solver.
    pub fn with_rate(mut self, rate: f64) -> Self {
        self.curriculum.rate = rate;
        self.solve_stages(|s| s.rate = None)
    }

    /// The same with this many epochs at most in every stage that is trained through the solver.
    pub fn with_epochs(self, epochs: usize) -> Self {
        self.solve_stages(|s| s.epochs = epochs)
    }

    /// The same with a value of the curriculum changed, as `pam train --set` does: `stage.1.matching.steps=500`.
    pub fn with_setting(mut self, change: impl Into<String>) -> Self {
        self.settings.push(change.into());
        self
    }

    /// The same with another seed of weights and batches.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    fn solve_stages(mut self, mut change: impl FnMut(&mut crate::curriculum::SolveStage)) -> Self {
        for stage in &mut self.curriculum.stages {
            if let Stage::Solve(stage) = stage {
                change(stage);
            }
        }
        self
    }

    /// The trainer, which does one epoch after another.
    ///
    /// # Errors
    /// [`TrainingError::Curriculum`] if a setting makes no sense or a recording is both trained on and held
    /// out; else as [`Trainer::new`].
    pub fn trainer(self) -> Result<Trainer, TrainingError> {
        let trained_on = |r: &&Recording| self.recordings.iter().any(|t| t.name == r.name);
        if let Some(both) = self.held_out.iter().find(trained_on) {
            return Err(TrainingError::Curriculum(format!(
                "`{}` is both trained on and held out",
                both.name
            )));
        }
        let mut curriculum = self.curriculum;
        if let Some(activation) = self.activation {
            let activation = activation?;
            // An activation with other parameters than those of its name is no part of a curriculum.
            let named = Activation::from_name(activation.name())?;
            if named != activation {
                return Err(TrainingError::Curriculum(format!(
                    "the activation `{}` has parameters {}, its name stands for {}; train from a model with it",
                    activation.name(),
                    activation.parameters_json(),
                    named.parameters_json()
                )));
            }
        }
        let names = self.recordings.iter().map(|r| r.name.clone()).collect();
        curriculum.data.train = Selection::Names(names);
        curriculum.data.held_out = Selection::Set(SelectionSet::Rest);
        // Reading it once more checks it, and applies the settings as `--set` does.
        let text = curriculum.to_toml();
        let path = Path::new(&curriculum.name);
        let curriculum = Curriculum::parse(&text, path, &self.settings).map_err(|e| {
            TrainingError::Curriculum(match e {
                CurriculumError::Override { text, message } => format!("{text}: {message}"),
                other => other.to_string(),
            })
        })?;
        let recordings: Vec<Recording> = self.recordings.into_iter().chain(self.held_out).collect();
        let trainer = match self.model {
            Some(model) => Trainer::from_model(curriculum, model, recordings, self.seed),
            None => Trainer::new(curriculum, recordings, self.surfaces, self.seed),
        }?;
        Ok(match self.loss {
            Some(loss) => {
                loss.check().map_err(|e| TrainingError::Curriculum(format!("the loss: {e}")))?;
                trainer.with_loss(loss)
            }
            None => trainer,
        })
    }

    /// Trains in memory.
    ///
    /// # Errors
    /// [`TrainingError`] naming the setting, or stage, epoch and recording.
    pub fn run(self) -> Result<Trained, TrainingError> {
        self.run_with(|_| {})
    }

    /// As [`run`](Self::run), with a closure that is called after every epoch.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_with(self, mut observe: impl FnMut(&EpochRow)) -> Result<Trained, TrainingError> {
        let mut trainer = self.trainer()?;
        let mut rows = Vec::new();
        while let Some(row) = trainer.advance()? {
            observe(&row);
            rows.push(row);
        }
        let state = trainer.state();
        let (results, events) = (state.results.clone(), state.events.clone());
        let run = TrainedRun { finished: true, results, events, rows };
        Ok(Trained { model: trainer.model(), run })
    }

    /// Trains with checkpoints and models in a folder, and goes on with what was begun there. `stop` ends
    /// the run after the running epoch.
    ///
    /// # Errors
    /// As [`run`](Self::run); what was reached is saved before.
    pub fn run_into(
        self,
        folder: impl AsRef<Path>,
        stop: &AtomicBool,
        mut observe: impl FnMut(&EpochRow),
    ) -> Result<Trained, TrainingError> {
        let folder = folder.as_ref();
        let mut trainer = self.trainer()?;
        let folder = RunFolder::new(folder);
        let settings = RunSettings {
            checkpoint_every: Duration::from_secs(10),
            model_name: format!("hybrid joint, {}", trainer.curriculum().name),
            made_by: concat!("pam-train ", env!("CARGO_PKG_VERSION")).to_owned(),
        };
        let resume = folder.has_checkpoint();
        let run = train_into(&mut trainer, &folder, &settings, resume, stop, &mut |row, _| {
            observe(row);
        })?;
        Ok(Trained { model: trainer.model(), run })
    }
}
