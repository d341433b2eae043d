//! Curricula that come with the crate, and what every curriculum must be.

use super::{Curriculum, CurriculumError, SelectionSet, Stage};
use crate::curriculum::Selection;
use crate::warm_start::random_network_len;
use pam_core::Activation;
use pam_trajectory::engine::GradientChoice;

/// Most weights of a random network, a hundred times those of the published one and more: training keeps several
/// copies of them.
const MOST_WEIGHTS: usize = 10_000_000;

const TEXTS: [(&str, &str); 5] = [
    ("recommended", include_str!("../../recipes/recommended.toml")),
    ("paper", include_str!("../../recipes/paper.toml")),
    ("horizons", include_str!("../../recipes/horizons.toml")),
    ("shooting", include_str!("../../recipes/shooting.toml")),
    ("joint", include_str!("../../recipes/joint.toml")),
];

impl Curriculum {
    /// Names of the curricula that come with the crate.
    pub const BUILT_IN: [&'static str; 5] =
        [TEXTS[0].0, TEXTS[1].0, TEXTS[2].0, TEXTS[3].0, TEXTS[4].0];

    /// The TOML text of a curriculum that comes with the crate.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        TEXTS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
    }

    /// Checks that the curriculum makes sense.
    pub(super) fn check(&self) -> Result<(), CurriculumError> {
        let fail =
            |message: String| Err(CurriculumError::Sense { name: self.name.clone(), message });
        let positive = |v: f64| v.is_finite() && v > 0.0;
        if self.stages.is_empty() {
            return fail("there is no [[stage]]".into());
        }
        if !positive(self.rate) || self.clip.is_nan() || self.clip <= 0.0 {
            return fail(format!("rate = {} and clip = {} must be positive", self.rate, self.clip));
        }
        if self.score_every == Some(0) {
            return fail(
                "score_every must be at least one; leave it out for ends of stages only".into(),
            );
        }
        if let Err(e) = Activation::from_name(&self.model.activation) {
            return fail(format!("model.activation: {e}"));
        }
        if self.model.hidden.contains(&0) {
            return fail("model.hidden: a layer has no width".into());
        }
        let weights = random_network_len(&self.model.hidden);
        if weights.is_none_or(|count| count > MOST_WEIGHTS) {
            return fail(format!(
                "model.hidden = {:?} has more than {MOST_WEIGHTS} weights, the most that are trained",
                self.model.hidden
            ));
        }
        let held_out_is_said =
            matches!(self.data.held_out, Selection::Names(_) | Selection::Share(_));
        if self.data.train == Selection::Set(SelectionSet::None)
            || (self.data.train == Selection::Set(SelectionSet::Rest) && !held_out_is_said)
        {
            return fail("data.train: name what is trained on".into());
        }
        for (key, selection) in [("train", &self.data.train), ("held_out", &self.data.held_out)] {
            if let Selection::Share(share) = selection
                && !(*share > 0.0 && *share < 1.0)
            {
                return fail(format!("data.{key}: a share lies between 0 and 1, got {share}"));
            }
        }
        if let Err(e) = self.solver.settings() {
            return fail(format!("solver: {e}"));
        }
        if !positive(self.coordinates.effect_rate) {
            return fail("coordinates.effect_rate must be positive".into());
        }
        let checked = self
            .loss
            .check()
            .and_then(|()| self.optimiser.check())
            .and_then(|()| self.schedule.check())
            .and_then(|()| self.regularisers.iter().try_for_each(|r| r.check()));
        if let Err(e) = checked {
            return fail(e.to_string());
        }
        for stage in &self.stages {
            let name = stage.name();
            if let Stage::Derivatives(s) = stage
                && let Err(e) = s.matching.check()
            {
                return fail(format!("stage `{name}`: matching.{e}"));
            }
            let Stage::Solve(s) = stage else { continue };
            if s.epochs == 0 || s.batch == Some(0) {
                return fail(format!("stage `{name}`: epochs and batch must be at least one"));
            }
            if s.rate.is_some_and(|r| !positive(r))
                || s.clip.is_some_and(|c| c.is_nan() || c <= 0.0)
            {
                return fail(format!("stage `{name}`: rate and clip must be positive"));
            }
            if s.horizon_s.is_some_and(|h| !positive(h)) {
                return fail(format!("stage `{name}`: horizon_s must be positive"));
            }
            if s.shooting.is_some() && s.horizon_s.is_none() {
                return fail(format!("stage `{name}`: shooting needs windows, give horizon_s"));
            }
            if s.shooting.is_some() && s.batch.is_some() {
                return fail(format!(
                    "stage `{name}`: shooting takes all windows at once, drop batch"
                ));
            }
            let checked = s
                .loss
                .as_ref()
                .map_or(Ok(()), |l| l.check())
                .and_then(|()| s.optimiser.as_ref().map_or(Ok(()), |o| o.check()))
                .and_then(|()| s.schedule.as_ref().map_or(Ok(()), |o| o.check()));
            if let Err(e) = checked {
                return fail(format!("stage `{name}`: {e}"));
            }
            let whole = s.optimiser.as_ref().unwrap_or(&self.optimiser).adam().is_none();
            if whole && (s.batch.is_some() || s.shooting.is_some()) {
                return fail(format!(
                    "stage `{name}`: lbfgs needs the same loss at every step, drop batch and shooting"
                ));
            }
            if !(s.auxiliary_damping.is_finite() && s.auxiliary_damping >= 0.0) {
                return fail(format!("stage `{name}`: auxiliary_damping must not be negative"));
            }
            let solver = s.solver.as_ref().unwrap_or(&self.solver);
            let own_adjoint =
                matches!(solver.gradient_choice(), Ok(GradientChoice::Adjoint) | Err(_));
            if s.shooting.is_some() && !own_adjoint {
                return fail(format!(
                    "stage `{name}`: shooting takes solver.gradient auto or adjoint, not {}",
                    solver.gradient
                ));
            }
            if let Some(Err(e)) = s.solver.as_ref().map(super::SolverChoice::settings) {
                return fail(format!("stage `{name}`: solver: {e}"));
            }
        }
        Ok(())
    }
}
