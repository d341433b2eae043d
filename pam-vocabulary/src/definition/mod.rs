//! Effects that are defined by expressions, as data.
//!
//! A TOML file defines one or more effects; with the feature `files`, `EffectDefinition::read_all` reads it and
//! `EffectDefinition::to_toml` writes one. A [`Language`] says which variables there are and where an effect can act: [`Language::joint`] is that of the
//! joint, [`Language::field`] that of any vector field with named states and inputs.
//!
//! ```
//! # #[cfg(feature = "files")] {
//! use pam_vocabulary::definition::{EffectDefinition, Language};
//!
//! let text = r#"
//! [[effect]]
//! id = "quadratic_drag"
//! description = "drag that grows with the square of the speed"
//! parameters.drag_n_s2_mm2 = { range = [0, 10], absent = 0 }
//! acts.force_n = "-drag_n_s2_mm2 * v * abs(v)"
//! "#;
//! let effects = EffectDefinition::read_all(text, &Language::joint())?;
//! assert_eq!(effects[0].parameters[0].name, "drag_n_s2_mm2");
//! let wrong = text.replace("abs(v)", "abs(w)");
//! let error = EffectDefinition::read_all(&wrong, &Language::joint()).expect_err("there is no w");
//! assert!(error.to_string().starts_with("line 6, column 42: there is no name `w`"), "{error}");
//! # }
//! # Ok::<(), pam_vocabulary::expression::ExpressionError>(())
//! ```

mod kept;
mod language;
#[cfg(feature = "files")]
mod read;
#[cfg(feature = "files")]
mod write;

pub use kept::keep;
pub use language::{Language, Moment, Place};

use crate::expression::Expression;
use crate::{EffectInfo, Group, ParameterInfo, Switch};
use kept::{KeptTexts, keep_info};

/// An expression as text and as tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// The text.
    pub text: String,
    /// The tree; its names are those of [`EffectDefinition::names`], unless said otherwise.
    pub tree: Expression,
}

/// A parameter of a defined effect.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterDefinition {
    /// Name, with its unit as suffix.
    pub name: String,
    /// One line.
    pub meaning: String,
    /// Smallest and largest physical value.
    pub range: [f64; 2],
    /// `true` for a positive scale that is fitted by its logarithm.
    pub logarithmic: bool,
    /// The value at which the parameter contributes nothing.
    pub absent: Option<f64>,
    /// Index of another parameter that is a lower bound of this one in a fit.
    pub not_below: Option<usize>,
    /// Values from which a fit may start; names are those of [`Language::scales`].
    pub starts: Vec<Formula>,
}

/// A switch of a defined effect.
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchDefinition {
    /// Name.
    pub name: String,
    /// The variants.
    pub meaning: String,
    /// The values that are tried.
    pub values: Vec<f64>,
}

/// A remembered number.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryDefinition {
    /// Name.
    pub name: String,
    /// Its value at the beginning; 0 unless given.
    pub start: Formula,
    /// How it changes.
    pub law: MemoryLaw,
}

/// How a remembered number changes.
#[derive(Debug, Clone, PartialEq)]
pub enum MemoryLaw {
    /// Its time derivative.
    Rate(Formula),
    /// Its value after a step that began `dt` (s) and `dx` (mm) ago, from the values at the beginning of the step.
    Step(Formula),
}

impl MemoryLaw {
    /// The formula.
    #[must_use]
    pub fn formula(&self) -> &Formula {
        match self {
            Self::Rate(formula) | Self::Step(formula) => formula,
        }
    }
}

/// An effect that is defined by expressions.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectDefinition {
    /// Id.
    pub id: String,
    /// Group.
    pub group: Group,
    /// One line: a noun phrase.
    pub description: String,
    /// The excitation under which it shows best.
    pub excited_by: String,
    /// Parameters, in the order of the file.
    pub parameters: Vec<ParameterDefinition>,
    /// Switches.
    pub switches: Vec<SwitchDefinition>,
    /// Named parts of the expressions; each may use those before it.
    pub lets: Vec<(String, Formula)>,
    /// Remembered numbers.
    pub memory: Vec<MemoryDefinition>,
    /// Where it acts, as indices into [`Language::places`], and the expression there.
    pub acts: Vec<(usize, Formula)>,
    /// A condition on fitted values, over parameters, switches and [`Language::scales`]: 0 where the values are no longer
    /// this effect.
    pub valid: Option<Formula>,
    /// Every name that its expressions may use, in this order: variables of the language, parameters, switches,
    /// remembered numbers, named parts.
    pub names: Vec<String>,
    /// Names of [`valid`](Self::valid): parameters, switches, scales.
    pub valid_names: Vec<String>,
}

/// Meaning of a name in an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// A variable of the language.
    Variable(usize),
    /// A value of the effect: parameters, then switches.
    Value(usize),
    /// A remembered number.
    Memory(usize),
    /// A named part.
    Let(usize),
}

impl EffectDefinition {
    /// Number of values: parameters, then switches.
    #[must_use]
    pub fn value_len(&self) -> usize {
        self.parameters.len() + self.switches.len()
    }

    /// Meaning of a name, by its index.
    #[must_use]
    pub fn symbol(&self, name: usize) -> Symbol {
        let own = self.value_len() + self.memory.len() + self.lets.len();
        let variables = self.names.len() - own;
        let after = |from: usize| name - from;
        let memory = variables + self.value_len();
        let lets = memory + self.memory.len();
        match name {
            k if k < variables => Symbol::Variable(k),
            k if k < memory => Symbol::Value(after(variables)),
            k if k < lets => Symbol::Memory(after(memory)),
            _ => Symbol::Let(after(lets)),
        }
    }

    /// The expression at a place, by the name of the place.
    #[must_use]
    pub fn act(&self, language: &Language, place: &str) -> Option<&Formula> {
        let k = language.places.iter().position(|p| p.name == place)?;
        self.acts.iter().find(|(place, _)| *place == k).map(|(_, formula)| formula)
    }

    /// The description in the form of the vocabulary. It stays for the life of the process; equal ones are one.
    #[must_use]
    pub fn info(&self) -> &'static EffectInfo {
        let parameters: Vec<ParameterInfo> = self
            .parameters
            .iter()
            .map(|p| ParameterInfo {
                name: keep(&p.name),
                meaning: keep(&p.meaning),
                range: p.range,
                logarithmic: p.logarithmic,
                off: p.absent,
                not_below: p.not_below,
            })
            .collect();
        let switches: Vec<Switch> = self
            .switches
            .iter()
            .map(|s| Switch { name: keep(&s.name), meaning: keep(&s.meaning) })
            .collect();
        let texts = EffectInfo {
            id: keep(&self.id),
            name: "",
            group: self.group,
            description: keep(&self.description),
            parameters: &[],
            switches: &[],
            excited_by: keep(&self.excited_by),
        };
        keep_info(KeptTexts { texts, parameters: &parameters, switches: &switches })
    }
}
