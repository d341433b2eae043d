//! Training and held-out recordings.

use super::config::ComparisonConfig;
use crate::error::BaselineError;
use pam_data::Subject;

/// Recordings as the configuration splits them.
#[derive(Debug, Clone, Default)]
pub struct Split {
    /// To fit to.
    pub train: Vec<Subject>,
    /// To score on.
    pub held_out: Vec<Subject>,
}

/// Sorts recordings into the two sets.
///
/// # Errors
/// [`BaselineError::Unfit`] if there is nothing to fit to, or a recording is shorter than the warm-up.
pub fn split(config: &ComparisonConfig, subjects: Vec<Subject>) -> Result<Split, BaselineError> {
    let mut sets = Split::default();
    for subject in subjects {
        let r = &subject.recording;
        let train = config.data.train.takes(&r.name, false);
        let held = !train && config.data.held_out.takes(&r.name, false);
        if (train || held) && r.len() < 2 * config.evaluation.warm_up + 2 {
            return Err(BaselineError::unfit(
                &r.name,
                format!(
                    "{} samples are too few for a warm-up of {}",
                    r.len(),
                    config.evaluation.warm_up
                ),
            ));
        }
        if train {
            sets.train.push(subject);
        } else if held {
            sets.held_out.push(subject);
        }
    }
    if sets.train.is_empty() {
        return Err(BaselineError::unfit(
            "data.train",
            "it selects none of the recordings; select \"all\", or give their names",
        ));
    }
    Ok(sets)
}
