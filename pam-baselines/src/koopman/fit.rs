//! The regression.

use super::{Koopman, KoopmanModel, Rollout, Stability, Standard};
use crate::error::BaselineError;
use crate::method::is_positive;
use crate::regression::Moments;
use pam_core::parallel;
use pam_data::recording::median_step_s;
use pam_data::{Channel, Recording, Subject};
use std::time::Instant;

impl Koopman {
    /// Fits K, and A for the pure lifted rollout, to all pairs of neighbouring samples.
    ///
    /// # Errors
    /// [`BaselineError::Unfit`] if recordings are sampled differently, a column does not vary, or the
    /// terms are dependent and the ridge is zero.
    pub fn regress(&self, subjects: &[Subject]) -> Result<KoopmanModel, BaselineError> {
        let fail = |why: String| BaselineError::unfit("Koopman", why);
        let begun = Instant::now();
        let recordings: Vec<&Recording> = subjects.iter().map(|s| &s.recording).collect();
        let step_s = common_step_s(&recordings).map_err(fail)?;
        let (state, input) = standard_of(&recordings).map_err(fail)?;

        let terms = self.dictionary.len();
        let parts: Vec<Moments> = parallel::map_each(recordings.clone(), |r: &Recording| {
            let mut moments = Moments::new(terms + 1, terms);
            let at = |k: usize| {
                let x = Channel::ALL.map(|c| r.channel(c)[k]);
                (state.apply(&x), input.apply(&[r.force_mn[k]])[0])
            };
            let mut lifted = vec![0.0; terms];
            let (x, mut force) = at(0);
            self.dictionary.lift(&x, &mut lifted);
            for k in 1..r.len() {
                let (x, next_force) = at(k);
                moments.add(|features, targets| {
                    features[..terms].copy_from_slice(&lifted);
                    features[terms] = force;
                    self.dictionary.lift(&x, targets);
                    lifted.copy_from_slice(targets);
                });
                force = next_force;
            }
            moments
        });
        let mut parts = parts.into_iter();
        let mut moments = parts.next().ok_or_else(|| fail("there are no recordings".into()))?;
        parts.for_each(|part| moments.merge(part));
        let lifted_map = moments.solve(self.ridge).ok_or_else(|| {
            fail(format!("the terms are dependent; take a larger ridge than {}", self.ridge))
        })?;
        // The rows of the state within the lifted map are K.
        let map = lifted_map[terms + 1..5 * (terms + 1)].to_vec();
        let mut model = KoopmanModel {
            dictionary: self.dictionary,
            map,
            lifted_map: Some(lifted_map),
            state,
            input,
            step_s: Some(step_s),
            rollout: self.rollout,
            fit_s: begun.elapsed().as_secs_f64(),
            stability: Stability::default(),
        };
        let starts: Vec<[f64; 4]> = recordings.iter().map(|r| r.initial_state()).collect();
        model.stability = Stability::of(&model, &starts);
        if self.rollout == Rollout::Relifted {
            model.lifted_map = None;
        }
        Ok(model)
    }
}

/// The sampling interval of all recordings, s.
pub(crate) fn common_step_s(recordings: &[&Recording]) -> Result<f64, String> {
    let Some(first) = recordings.first() else { return Err("there are no recordings".into()) };
    let step = median_step_s(&first.time_s);
    for r in recordings {
        let own = median_step_s(&r.time_s);
        if (own - step).abs() > 0.01 * step {
            return Err(format!(
                "{} is sampled every {own} s, {} every {step} s; a discrete-time model needs one rate",
                r.name, first.name
            ));
        }
    }
    Ok(step)
}

/// Standardisation of state and force over recordings.
pub(crate) fn standard_of(recordings: &[&Recording]) -> Result<(Standard<4>, Standard<1>), String> {
    let stats = Channel::ALL.map(|c| {
        let columns: Vec<&[f64]> = recordings.iter().map(|r| r.channel(c)).collect();
        mean_and_deviation(&columns)
    });
    let forces: Vec<&[f64]> = recordings.iter().map(|r| &r.force_mn[..]).collect();
    let (mean, deviation) = mean_and_deviation(&forces);
    let state = Standard { mean: stats.map(|s| s.0), deviation: stats.map(|s| s.1) };
    let input = Standard { mean: [mean], deviation: [deviation] };
    let all = state.deviation.iter().chain(&input.deviation);
    for (what, deviation) in ["x", "ẋ", "P_f", "P_e", "F"].iter().zip(all) {
        if !is_positive(*deviation) {
            return Err(format!("{what} does not vary over the training recordings"));
        }
    }
    Ok((state, input))
}

/// Mean and standard deviation over several columns, in two passes.
fn mean_and_deviation(columns: &[&[f64]]) -> (f64, f64) {
    let count: usize = columns.iter().map(|c| c.len()).sum();
    let share = 1.0 / count.max(1) as f64;
    let mean = share * columns.iter().map(|c| c.iter().sum::<f64>()).sum::<f64>();
    let square: f64 =
        columns.iter().map(|c| c.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()).sum();
    (mean, (share * square).sqrt())
}
