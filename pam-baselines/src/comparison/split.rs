//! Training and held-out recordings.

use super::config::ComparisonConfig;
use crate::error::BaselineError;
use pam_data::Subject;
use pam_train::curriculum::{DataSettings, SplitRole};

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
    let settings = DataSettings {
        train: config.data.train.clone(),
        held_out: config.data.held_out.clone(),
        ..DataSettings::default()
    };
    let names: Vec<&str> = subjects.iter().map(|s| s.recording.name.as_str()).collect();
    settings.check_names(&names).map_err(|why| BaselineError::unfit(&config.name, why))?;
    let roles = settings.roles(&names);
    for (subject, role) in subjects.into_iter().zip(roles) {
        let r = &subject.recording;
        if role != SplitRole::Unused && r.len() < 2 * config.evaluation.warm_up + 2 {
            return Err(BaselineError::unfit(
                &r.name,
                format!(
                    "{} samples are too few for a warm-up of {}",
                    r.len(),
                    config.evaluation.warm_up
                ),
            ));
        }
        match role {
            SplitRole::Train => sets.train.push(subject),
            SplitRole::HeldOut => sets.held_out.push(subject),
            SplitRole::Unused => {}
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
