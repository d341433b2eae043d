//! Systems to which terms can be added.

use super::definition::Definition;
use super::term::Term;
use super::unit::Unit;
use crate::error::DiagnoseError;
use crate::search::{Candidates, Remembered, Work};
use std::sync::Arc;

/// A quantity that terms may depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name in sentences, "displacement".
    pub name: String,
    /// As an expression: a name, or a formula in brackets.
    pub text: String,
    /// Name of the variables with which it is left out of a correction.
    pub group: String,
    /// The names that the expression uses.
    pub names: Vec<String>,
    /// Unit.
    pub unit: Unit,
    /// Unit as it is written.
    pub unit_text: String,
    /// Typical size in the data.
    pub size: f64,
    /// How terms depend on it.
    pub kind: VariableKind,
    /// Whether it takes both signs.
    pub signed: bool,
    /// Its value at the beginning of an experiment, as an expression, if it can be remembered: whole if it moves, and a pressure as what
    /// a low-pass leaves of it.
    pub at_start: Option<String>,
    /// Its change over a step, as an expression, if terms may remember where it turned.
    pub change: Option<String>,
    /// Length of its description, nats.
    pub description_length: f64,
}

impl Variable {
    /// Whether it is one of the slow variables that differ between experiments, and not the time.
    #[must_use]
    pub fn is_pressure(&self) -> bool {
        self.kind == VariableKind::Slow && self.group == "pressures"
    }

    /// Whether terms may contain low-passes of it: it moves and has a known initial value.
    #[must_use]
    pub fn is_remembered(&self) -> bool {
        self.at_start.is_some() && matches!(self.kind, VariableKind::Moving | VariableKind::Turning)
    }

    /// Whether terms may contain its high-pass: it is a pressure with a known initial value.
    #[must_use]
    pub fn relaxes(&self) -> bool {
        self.at_start.is_some() && !self.is_remembered()
    }

    /// Whether it is the time.
    #[must_use]
    pub fn is_time(&self) -> bool {
        self.names == ["t"]
    }
}

/// How terms depend on a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableKind {
    /// It moves: powers of it, and products with others.
    Moving,
    /// It moves, and its direction matters: it may be a velocity, against which there is friction.
    Turning,
    /// It changes slowly, or from one experiment to the next: a pressure, the time.
    Slow,
    /// It is a combination of others, which a short law may use.
    Combined,
}

/// Where a term acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Id, `force`.
    pub id: String,
    /// Name in sentences, "force on the joint".
    pub name: String,
    /// Unit of a term there.
    pub unit: Unit,
    /// Unit as it is written.
    pub unit_text: String,
    /// Size of a term that would matter there.
    pub size: f64,
    /// What the system adds terms to: a place of its expressions, what stands there without terms (empty for nothing), and
    /// the factor of the terms.
    pub targets: Vec<(String, String, f64)>,
    /// Indices of the variables that are known there.
    pub variables: Vec<usize>,
    /// Whether much may act there in many ways, as forces do.
    pub rich: bool,
    /// Whether a term there may remember.
    pub remembers: bool,
    /// Index of the place for the level of a dry friction, of which a force that saturates in the velocity here is the smooth
    /// picture, and of the velocity.
    pub dry: Option<(usize, usize)>,
    /// Number of the family of places that are tried together.
    pub family: usize,
    /// Length of its description, nats.
    pub description_length: f64,
}

/// Whether terms at a place set the level of a dry friction.
pub(crate) fn is_dry_level(place: usize, places: &[Place]) -> bool {
    places.iter().any(|p| p.dry.is_some_and(|(level, _)| level == place))
}

/// A system to whose candidates terms can be added.
pub trait TermSpace: Sync {
    /// What terms may depend on.
    fn variables(&self) -> &[Variable];

    /// Where terms may act.
    fn places(&self) -> &[Place];

    /// What counts the simulations of its systems.
    fn work(&self) -> Arc<Work> {
        Arc::default()
    }

    /// Calls `then` once with the system whose candidates are its own and, behind them, these definitions.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a definition cannot be understood, and those of `then`.
    fn call_with(
        &self,
        definitions: &[Definition],
        then: &mut dyn FnMut(&dyn Candidates) -> Result<(), DiagnoseError>,
    ) -> Result<(), DiagnoseError>;

    /// The variables at the grid points of an experiment, as measured where they are measured.
    fn series(&self, experiment: usize) -> Vec<Vec<f64>>;

    /// Time between two grid points of an experiment, s.
    fn step_s(&self, experiment: usize) -> f64;

    /// The candidate of the system's list that does what a term does, whatever its coefficient is.
    fn listed(&self, term: &Term) -> Option<&'static str> {
        let _ = term;
        None
    }

    /// The file that holds definitions.
    fn file(&self, definitions: &[Definition]) -> String;
}

impl dyn TermSpace + '_ {
    /// What `then` makes of the system with definitions behind its candidates. The system keeps its latest simulations: a fit, its
    /// errors on other rows and the design about it ask for the same ones.
    ///
    /// # Errors
    /// As [`call_with`](TermSpace::call_with).
    pub fn with<R>(
        &self,
        definitions: &[Definition],
        then: impl FnOnce(&dyn Candidates) -> Result<R, DiagnoseError>,
    ) -> Result<R, DiagnoseError> {
        let (mut then, mut made) = (Some(then), None);
        self.call_with(definitions, &mut |system| {
            if let Some(then) = then.take() {
                made = Some(then(&Remembered::new(system, self.work()))?);
            }
            Ok(())
        })?;
        made.ok_or_else(|| DiagnoseError::TooLittle("the system was not made".into()))
    }
}
