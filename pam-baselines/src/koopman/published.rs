//! The published model.

use super::{Dictionary, KoopmanModel, Rollout, Stability, Standard};
use crate::error::BaselineError;
use pam_data::formats::npz;
use std::path::Path;

/// Reads the published model (`koopman_model.npz`: `K`, `X_mean`, `X_std`, `U_mean`, `U_std`). The
/// dictionary follows from the number of columns of K.
///
/// # Errors
/// [`BaselineError`] if an array is missing or of another shape.
pub fn read_published(path: &Path) -> Result<KoopmanModel, BaselineError> {
    let arrays = npz::read(path)?;
    let take = |name: &str| {
        arrays.get(name).ok_or_else(|| {
            BaselineError::file(path, format!("there is no array `{name}`; is it a Koopman model?"))
        })
    };
    let map = take("K")?;
    let [4, columns] = map.shape[..] else {
        return Err(BaselineError::file(
            path,
            format!("`K` has shape {:?}, not [4, n]", map.shape),
        ));
    };
    let dictionary = usize::try_from(columns)
        .ok()
        .and_then(|c| Dictionary::of_len(c.saturating_sub(1)))
        .ok_or_else(|| {
            BaselineError::file(path, format!("no dictionary has {columns} columns with the input"))
        })?;
    let four = |name: &str| -> Result<[f64; 4], BaselineError> {
        take(name)?.values[..]
            .try_into()
            .map_err(|_| BaselineError::file(path, format!("`{name}` must hold four numbers")))
    };
    let one = |name: &str| -> Result<[f64; 1], BaselineError> {
        take(name)?.values[..]
            .try_into()
            .map_err(|_| BaselineError::file(path, format!("`{name}` must hold one number")))
    };
    let mut model = KoopmanModel {
        dictionary,
        map: map.values.clone(),
        lifted_map: None,
        state: Standard { mean: four("X_mean")?, deviation: four("X_std")? },
        input: Standard { mean: one("U_mean")?, deviation: one("U_std")? },
        step_s: None,
        rollout: Rollout::Relifted,
        fit_s: 0.0,
        stability: Stability::default(),
    };
    let mean = model.state.mean;
    model.stability = Stability::of(&model, &[mean]);
    Ok(model)
}
