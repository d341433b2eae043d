//! Loss, gradient and scores, by the fast path in single or double precision or by any gradient method.

use super::trainer::TrainingError;
use crate::curriculum::Precision;
use crate::extension::Extension;
use pam_data::Subject;
use pam_data::{Channel, Recording};
use pam_trajectory::gradient::NetworkJoint;
use pam_trajectory::gradient::sealed::IndexedLoss;
use pam_trajectory::gradient::{ExtendedGradient, ExtendedRequest};
use pam_trajectory::gradient::{GradientChoice, JointGradient, SealedGradient, general};
use pam_trajectory::metrics::r2;
use pam_trajectory::predict::SolverSettings;
use pam_trajectory::windows::Windows;
use std::sync::Arc;

/// How loss and gradient are found.
#[derive(Debug)]
pub enum Engine {
    /// Single precision in the network.
    F32(SealedGradient<f32>),
    /// Double precision.
    F64(SealedGradient<f64>),
    /// Any gradient method, in doubles, recording by recording; predictions alone by the fast path.
    General(Box<GeneralEngine>),
    /// A model with an extension.
    Extended(Box<ExtendedEngine>),
}

/// The gradient of an extension, made for the windows that it is first asked for.
#[derive(Debug)]
pub struct ExtendedEngine {
    extension: Arc<dyn Extension>,
    precision: Precision,
    gradient: Option<Box<dyn ExtendedGradient>>,
}

/// A gradient method besides the fast path's.
#[derive(Debug)]
pub struct GeneralEngine {
    choice: GradientChoice,
    settings: SolverSettings,
    /// Predicted states of the last gradient.
    states: Vec<Vec<[f64; 4]>>,
    values: SealedGradient<f64>,
}

impl Engine {
    /// An engine for the settings of a stage. Without a gradient method the fast path has its own, the
    /// exact adjoint of its steps or pieces.
    #[must_use]
    pub fn new(
        settings: SolverSettings,
        precision: Precision,
        gradient: Option<GradientChoice>,
    ) -> Self {
        if let Some(choice) = gradient {
            let values = SealedGradient::new(settings.clone());
            let states = Vec::new();
            return Self::General(Box::new(GeneralEngine { choice, settings, states, values }));
        }
        match precision {
            Precision::F32 => Self::F32(SealedGradient::new(settings)),
            Precision::F64 => Self::F64(SealedGradient::new(settings)),
        }
    }

    /// An engine for a model with an extension, which is simulated in its own way.
    #[must_use]
    pub fn extended(extension: Arc<dyn Extension>, precision: Precision) -> Self {
        Self::Extended(Box::new(ExtendedEngine { extension, precision, gradient: None }))
    }

    /// See [`SealedGradient::value_and_gradient_from`].
    ///
    /// # Errors
    /// [`TrainingError`] if a recording cannot drive a solve, or an extension cannot be simulated so.
    pub fn value_and_gradient(
        &mut self,
        request: &ExtendedRequest<'_>,
        loss: &IndexedLoss<'_>,
    ) -> Result<JointGradient, TrainingError> {
        let ExtendedRequest { model, starts, .. } = *request;
        let mut picked = Vec::new();
        let subjects = &mut picked;
        Ok(match self {
            Self::Extended(e) => {
                if e.gradient.is_none() {
                    e.gradient = Some(e.extension.engine(request.windows, e.precision)?);
                }
                let gradient = e.gradient.as_mut().expect("just made");
                gradient.value_and_gradient(request, loss, true)
            }
            Self::F32(g) => {
                g.value_and_gradient_from(model, asked_for(request, subjects), starts, loss)?
            }
            Self::F64(g) => {
                g.value_and_gradient_from(model, asked_for(request, subjects), starts, loss)?
            }
            Self::General(g) => {
                let silent: (&dyn Fn(usize), &(dyn Fn() + Sync)) = (&|_| {}, &|| {});
                let mut found = general::value_and_gradient_from(
                    g.choice,
                    model,
                    (asked_for(request, subjects), starts),
                    &g.settings,
                    loss,
                    silent,
                )?;
                g.states = std::mem::take(&mut found.states);
                found
            }
        })
    }

    /// Predicted states of a recording from the last call; of methods that keep them for themselves
    /// there are none.
    pub fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        match self {
            Self::General(g) => &g.states[index],
            Self::Extended(e) => e.gradient.as_ref().map_or(&[], |g| g.predicted(index)),
            Self::F32(g) => g.predicted(index),
            Self::F64(g) => g.predicted(index),
        }
    }

    /// Mean R² of `[x, ẋ, P_f, P_e]` over recordings that are predicted to their end from their first
    /// sample; `None` where no recording gives one.
    ///
    /// # Errors
    /// [`TrainingError`] if a recording cannot drive a solve, or an extension cannot be simulated.
    pub fn mean_r2(
        &mut self,
        model: &NetworkJoint,
        extension_values: &[f64],
        subjects: &[Subject],
    ) -> Result<[Option<f64>; 4], TrainingError> {
        let zero = |_: usize, _: &Recording, _: &[[f64; 4]], _: &mut [[f64; 4]]| 0.0;
        let (mut sums, mut counts) = ([0.0; 4], [0.0; 4]);
        // In portions, because the predicted states of all recordings stay in memory.
        for portion in subjects.chunks(PORTION) {
            let starts: Vec<_> = portion.iter().map(|s| s.recording.initial_state()).collect();
            let failures = match self {
                Self::F32(g) => g.values_from(model, portion, &starts, &zero)?.failures,
                Self::F64(g) => g.values_from(model, portion, &starts, &zero)?.failures,
                Self::General(g) => g.values.values_from(model, portion, &starts, &zero)?.failures,
                Self::Extended(e) => {
                    let windows = Windows::of(portion, None);
                    let part: Vec<usize> = (0..portion.len()).collect();
                    let request = ExtendedRequest {
                        model,
                        values: extension_values,
                        windows: &windows,
                        part: &part,
                        starts: &starts,
                    };
                    let gradient = e.gradient.insert(e.extension.engine(&windows, e.precision)?);
                    gradient.value_and_gradient(&request, &zero, false).failures
                }
            };
            for (i, s) in portion.iter().enumerate() {
                if failures.iter().any(|f| f.problem == i) {
                    continue;
                }
                let states = match &mut *self {
                    Self::General(g) => g.values.predicted(i),
                    fast => fast.predicted(i),
                };
                for (c, channel) in Channel::ALL.into_iter().enumerate() {
                    let predicted: Vec<f64> = states.iter().map(|y| y[c]).collect();
                    let value = r2(s.recording.channel(channel), &predicted);
                    if value.is_finite() {
                        sums[c] += value;
                        counts[c] += 1.0;
                    }
                }
            }
        }
        Ok(std::array::from_fn(|c| (counts[c] > 0.0).then(|| sums[c] / counts[c])))
    }
}

/// The windows that are asked for; copied only where they are not all.
fn asked_for<'a>(request: &ExtendedRequest<'a>, picked: &'a mut Vec<Subject>) -> &'a [Subject] {
    let all = &request.windows.subjects;
    if request.part.len() == all.len() {
        return all;
    }
    picked.extend(request.part.iter().map(|&i| all[i].clone()));
    picked
}

/// Recordings that are scored at a time.
const PORTION: usize = 32;
