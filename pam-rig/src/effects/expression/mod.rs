//! Effects of a file, hidden by an evaluator of the rig's own.
//!
//! A diagnosis and the rig read the same notation ([`pam_vocabulary::definition`]). What the rig does with it is written here
//! once more: it walks the tree with plain numbers, moves memories by Heun's method at the plant's step, and takes
//! forces, air and volumes from the plant. Nothing is shared with the estimator that must find the effect.

mod evaluate;
mod phenomenon;

use crate::effects::{ALL, EffectInfo, Phenomenon};
use crate::error::RigError;
use pam_data::DataError;
use pam_vocabulary::VocabularyError;
use pam_vocabulary::definition::{EffectDefinition, Language};
use phenomenon::Hidden;
use std::path::Path;
use std::sync::{LazyLock, PoisonError, RwLock};

/// An effect that a file defines.
#[derive(Debug)]
pub struct ExpressionEffect {
    /// Its description in the form of the vocabulary.
    pub info: &'static EffectInfo,
    /// The file that defines it alone.
    pub text: String,
    definition: EffectDefinition,
}

/// Effects that were read, in that order; nothing is ever replaced.
static KNOWN: RwLock<Vec<&'static ExpressionEffect>> = RwLock::new(Vec::new());

pub(crate) static LANGUAGE: LazyLock<Language> = LazyLock::new(Language::joint);

/// Makes the effects of a file known by their ids, as `coulomb_friction` is.
///
/// # Errors
/// [`RigError::Data`] with file, line and column, or if another effect has the id.
pub fn load(path: impl AsRef<Path>) -> Result<Vec<&'static ExpressionEffect>, RigError> {
    let path = path.as_ref();
    let text = pam_data::toml_file::text(path)?;
    read(&text).map_err(|message| DataError::file(path, message).into())
}

/// As [`load`], from text.
///
/// # Errors
/// The fault, with line and column.
pub fn read(text: &str) -> Result<Vec<&'static ExpressionEffect>, String> {
    let definitions = EffectDefinition::read_all(text, &LANGUAGE).map_err(|e| e.to_string())?;
    definitions.into_iter().map(keep).collect()
}

fn keep(definition: EffectDefinition) -> Result<&'static ExpressionEffect, String> {
    let text = definition.to_toml(&LANGUAGE);
    let id = &definition.id;
    if ALL.iter().any(|e| e.info.id == id) {
        return Err(format!("the rig has an effect `{id}` of its own; give yours another id"));
    }
    let mut known = KNOWN.write().unwrap_or_else(PoisonError::into_inner);
    if let Some(there) = known.iter().find(|e| e.info.id == id) {
        return if there.text == text {
            Ok(there)
        } else {
            Err(format!("there is another effect `{id}` already; give yours another id"))
        };
    }
    let info = definition.info();
    let effect: &'static _ = Box::leak(Box::new(ExpressionEffect { info, text, definition }));
    known.push(effect);
    Ok(effect)
}

/// The effects that were read.
#[must_use]
pub fn known() -> Vec<&'static ExpressionEffect> {
    KNOWN.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// The effect that a stored definition defines.
pub(super) fn of_definition(
    id: &str,
    text: &str,
) -> Result<&'static ExpressionEffect, VocabularyError> {
    let fail = |message: String| VocabularyError::Text { effect: id.to_owned(), message };
    let effects = read(text).map_err(fail)?;
    effects
        .into_iter()
        .find(|e| e.info.id == id)
        .ok_or_else(|| fail("its definition defines other effects".into()))
}

impl ExpressionEffect {
    /// The phenomenon at the start of a run, for values of parameters and switches.
    pub(super) fn start(&'static self, values: &[f64]) -> Box<dyn Phenomenon> {
        Box::new(Hidden::new(&self.definition, values))
    }
}
