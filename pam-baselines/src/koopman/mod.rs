//! Koopman operator by extended dynamic mode decomposition with control (EDMDc).
//!
//! ```text
//! x̃_{k+1} = K [ψ(x̃_k); ũ_k]        x̃, ũ standardised over the training recordings
//! ```
//!
//! fitted by ridge regression (Korda and Mezić 2018; Wang and Realmuto 2026, supplement A). A prediction
//! either lifts the predicted state anew at every step, or stays in the lifted space with the square map
//! `ψ_{k+1} = A [ψ_k; ũ_k]`, which is fitted to the same pairs.

mod dictionary;
mod fit;
mod stability;

pub(crate) use fit::{common_step_s, standard_of};

pub use dictionary::Dictionary;
pub use stability::{Mode, Stability};

use crate::error::BaselineError;
use crate::method::{
    FittedModel, Method, Run, Stopped, Structure, TrainingSet, Trajectory, diverged, out_of_range,
};
use crate::saved::SavedArrays;
use pam_data::formats::npz::Array;
use pam_data::recording::median_step_s;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// How a prediction goes on from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rollout {
    /// The predicted state is lifted anew.
    #[default]
    Relifted,
    /// The lifted state is mapped, and the state read from it.
    Lifted,
}

/// How the model is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Koopman {
    /// The dictionary.
    pub dictionary: Dictionary,
    /// λ of the ridge regression, on sums over all samples of standardised data.
    pub ridge: f64,
    /// How it predicts.
    pub rollout: Rollout,
}

impl Default for Koopman {
    fn default() -> Self {
        Self { dictionary: Dictionary::SecondOrder, ridge: 0.01, rollout: Rollout::Relifted }
    }
}

/// Mean and standard deviation of each column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standard<const N: usize> {
    /// Means.
    pub mean: [f64; N],
    /// Standard deviations.
    pub deviation: [f64; N],
}

impl<const N: usize> Standard<N> {
    /// `(x − mean)/deviation`.
    #[must_use]
    pub fn apply(&self, x: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| (x[i] - self.mean[i]) / self.deviation[i])
    }

    /// The inverse.
    #[must_use]
    pub fn invert(&self, x: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| x[i] * self.deviation[i] + self.mean[i])
    }
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct KoopmanModel {
    /// The dictionary.
    pub dictionary: Dictionary,
    /// K `[4][terms + 1]`, row by row; the last column is the input's.
    pub map: Vec<f64>,
    /// A `[terms][terms + 1]`, row by row, if it was fitted.
    pub lifted_map: Option<Vec<f64>>,
    /// Standardisation of the state (mm, mm/s, kPa, kPa).
    pub state: Standard<4>,
    /// Standardisation of the force (mN).
    pub input: Standard<1>,
    /// Time from one sample to the next, s; unknown for the published model.
    pub step_s: Option<f64>,
    /// How it predicts.
    pub rollout: Rollout,
    /// Seconds that the regression took; zero if it was read from a file.
    pub fit_s: f64,
    /// Its behaviour without input.
    pub stability: Stability,
}

impl KoopmanModel {
    /// Reads a model from an `.npz` file with the arrays that [`FittedModel::arrays`] gives, as `pam compare`
    /// writes them and Wang and Realmuto (2026) publish them:
    ///
    /// | array | shape | content |
    /// |---|---|---|
    /// | `K` | `[4, terms + 1]` | map of the lifted state and the input; its width determines the dictionary |
    /// | `X_mean`, `X_std` | `[4]` | standardisation of the state (mm, mm/s, kPa, kPa) |
    /// | `U_mean`, `U_std` | one number | standardisation of the force (mN) |
    /// | `A` | `[terms, terms + 1]` | optional: map of the lifted state, for the pure lifted rollout |
    /// | `step_s` | one number | optional: sampling interval, s |
    ///
    /// # Errors
    /// [`BaselineError`] if the file cannot be read, or an array is missing or of another shape.
    pub fn from_npz(path: impl AsRef<Path>) -> Result<Self, BaselineError> {
        Self::from_npz_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn from_npz_at(path: &Path) -> Result<Self, BaselineError> {
        let saved = SavedArrays::read(path)?;
        let [_, columns] = saved.rows_and_columns("K")?;
        let dictionary = Dictionary::of_len(columns.saturating_sub(1)).ok_or_else(|| {
            saved.error(format!("no dictionary has {columns} columns with the input"))
        })?;
        let lifted_map = if saved.has("A") {
            Some(saved.values("A", &[columns - 1, columns])?.to_vec())
        } else {
            None
        };
        let mut model = Self {
            dictionary,
            map: saved.values("K", &[4, columns])?.to_vec(),
            rollout: if lifted_map.is_some() { Rollout::Lifted } else { Rollout::Relifted },
            lifted_map,
            state: Standard { mean: saved.numbers("X_mean")?, deviation: saved.numbers("X_std")? },
            input: Standard { mean: saved.numbers("U_mean")?, deviation: saved.numbers("U_std")? },
            step_s: saved.optional("step_s")?,
            fit_s: 0.0,
            stability: Stability::default(),
        };
        let mean = model.state.mean;
        model.stability = Stability::of(&model, &[mean]);
        Ok(model)
    }

    /// The next state from a state `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa) under a force (mN).
    #[must_use]
    pub fn step(&self, state: &[f64; 4], force_mn: f64) -> [f64; 4] {
        let mut lifted = vec![0.0; self.dictionary.len()];
        let x = self.state.apply(state);
        let [u] = self.input.apply(&[force_mn]);
        self.state.invert(&self.step_standardised(&x, u, &mut lifted))
    }

    fn step_standardised(&self, x: &[f64; 4], u: f64, lifted: &mut [f64]) -> [f64; 4] {
        self.dictionary.lift(x, lifted);
        let columns = lifted.len() + 1;
        std::array::from_fn(|i| row_product(&self.map[i * columns..][..columns], lifted, u))
    }

    fn predict(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        let steps = run.len();
        if let Some(step_s) = self.step_s {
            let own = median_step_s(&run.recording.time_s);
            if (own - step_s).abs() > 0.01 * step_s {
                return Err(Stopped {
                    why: format!("samples are {own} s apart; the model was fitted to {step_s} s"),
                });
            }
        }
        let terms = self.dictionary.len();
        let (mut lifted, mut next) = (vec![0.0; terms], vec![0.0; terms]);
        let mut out = Trajectory::from_fn(|_| Vec::with_capacity(steps));
        let mut x = self.state.apply(&run.state());
        self.dictionary.lift(&x, &mut lifted);
        for k in 0..steps {
            let [position, velocity, pf, pe] =
                if k == 0 { run.state() } else { self.state.invert(&x) };
            if out_of_range(position) {
                return Err(diverged(run, k, position));
            }
            out.x.push(position);
            out.v.push(velocity);
            out.pf.push(pf);
            out.pe.push(pe);
            let [u] = self.input.apply(&[run.recording.force_mn[run.start + k]]);
            match (&self.lifted_map, self.rollout) {
                (Some(map), Rollout::Lifted) => {
                    for (to, row) in next.iter_mut().zip(map.chunks_exact(terms + 1)) {
                        *to = row_product(row, &lifted, u);
                    }
                    std::mem::swap(&mut lifted, &mut next);
                    x.copy_from_slice(&lifted[1..5]);
                }
                _ => x = self.step_standardised(&x, u, &mut lifted),
            }
        }
        Ok(out)
    }
}

/// `row · [lifted; u]`.
fn row_product(row: &[f64], lifted: &[f64], u: f64) -> f64 {
    let (state, input) = row.split_at(lifted.len());
    state.iter().zip(lifted).map(|(a, b)| a * b).sum::<f64>() + input[0] * u
}

impl FittedModel for KoopmanModel {
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        self.predict(run)
    }

    fn parameter_count(&self) -> usize {
        match (&self.lifted_map, self.rollout) {
            (Some(map), Rollout::Lifted) => map.len(),
            _ => self.map.len(),
        }
    }

    fn structure(&self) -> Structure {
        Structure::Dictionary
    }

    fn details(&self) -> Value {
        json!({
            "dictionary": self.dictionary,
            "terms": self.dictionary.len(),
            "rollout": self.rollout,
            "regression_s": self.fit_s,
            "stability": self.stability,
        })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let columns = (self.dictionary.len() + 1) as u64;
        let mut arrays = BTreeMap::from([
            ("K".into(), Array { shape: vec![4, columns], values: self.map.clone() }),
            ("X_mean".into(), Array::vector(self.state.mean.to_vec())),
            ("X_std".into(), Array::vector(self.state.deviation.to_vec())),
            ("U_mean".into(), Array::vector(self.input.mean.to_vec())),
            ("U_std".into(), Array::vector(self.input.deviation.to_vec())),
        ]);
        if let Some(map) = &self.lifted_map {
            let shape = vec![columns - 1, columns];
            arrays.insert("A".into(), Array { shape, values: map.clone() });
        }
        arrays.extend(self.step_s.map(|s| ("step_s".into(), Array::scalar(s))));
        arrays
    }
}

impl Method for Koopman {
    fn title(&self) -> String {
        let rollout = match self.rollout {
            Rollout::Relifted => "",
            Rollout::Lifted => ", pure lifted",
        };
        format!("Koopman, {}{rollout}", self.dictionary.name())
    }

    fn check(&self) -> Result<(), String> {
        if self.ridge.is_finite() && self.ridge >= 0.0 {
            Ok(())
        } else {
            Err(format!("ridge = {} must be finite and not negative", self.ridge))
        }
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        _progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        Ok(Box::new(self.regress(training.subjects)?))
    }
}
