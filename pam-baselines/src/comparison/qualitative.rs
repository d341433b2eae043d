//! The published qualitative table, filled from what was measured.

use super::result::ModelResult;
use crate::method::{Needs, Structure};
use serde::Serialize;

/// A grade of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// Not there.
    None,
    /// Weak.
    Weak,
    /// Only through simulated motions.
    Indirect,
    /// Moderate.
    Moderate,
    /// Strong.
    Strong,
}

impl Grade {
    /// In a word.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Weak => "weak",
            Self::Indirect => "indirect",
            Self::Moderate => "moderate",
            Self::Strong => "strong",
        }
    }
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Qualities {
    /// The model.
    pub name: String,
    /// Median held-out R² of the displacement from a cold start: strong from 0.9, moderate from 0.5.
    pub prediction: Grade,
    /// R² of the joint's force along measured motions: strong from 0.9, moderate from 0.5, else weak;
    /// none for a model without a force.
    pub force: Grade,
    /// Mean error of the stiffness ∂f/∂x: strong below 10 %, moderate below 25 %, else weak; for a model
    /// without a force indirect if the stiffness that its predicted motions show is within 25 %, else none.
    pub stiffness: Grade,
    /// Kind of equations, a property and no measurement: high for equations in physical units or
    /// with a learned force, moderate for a dictionary, low for weights.
    pub interpretability: &'static str,
    /// Inputs that a prediction needs.
    pub needs: Needs,
}

impl Qualities {
    /// The row of a model. Without held-out recordings the training ones are graded.
    #[must_use]
    pub fn of(model: &ModelResult) -> Self {
        let set = if model.cold.held_out.recordings.is_empty() {
            &model.cold.train
        } else {
            &model.cold.held_out
        };
        let m = &model.mechanics;
        let by_r2 = |r2: f64| match r2 {
            r if r >= 0.9 => Grade::Strong,
            r if r >= 0.5 => Grade::Moderate,
            _ => Grade::Weak,
        };
        Self {
            name: model.name.clone(),
            prediction: set.displacement.median.map_or(Grade::Weak, by_r2),
            force: m.force_r2.map_or(Grade::None, by_r2),
            stiffness: match (m.stiffness_error_percent, m.shown_stiffness_error_percent) {
                (Some(e), _) if e < 10.0 => Grade::Strong,
                (Some(e), _) if e < 25.0 => Grade::Moderate,
                (Some(_), _) => Grade::Weak,
                (None, Some(e)) if e < 25.0 => Grade::Indirect,
                _ => Grade::None,
            },
            interpretability: match model.structure {
                Structure::Physical | Structure::Hybrid => "high",
                Structure::Dictionary => "moderate",
                Structure::Network => "low",
            },
            needs: model.needs,
        }
    }
}
