//! Files of effects, and the effects that this process has from them.

use super::effect::ExpressionEffect;
use crate::effects::{ALL, AnyEffect};
use crate::error::EffectError;
use pam_vocabulary::definition::{EffectDefinition, Language};
use std::collections::HashMap;
use std::path::Path;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Effects by the text that defines them. One definition is one effect as long as the process runs, however often it is read.
static KNOWN: LazyLock<Mutex<HashMap<String, &'static ExpressionEffect>>> =
    LazyLock::new(Mutex::default);

/// Reads the effects of a TOML file.
///
/// They are parts of models and candidates of diagnoses like any effect. [`register`](crate::effects::register) makes
/// them known by their ids.
///
/// # Errors
/// [`EffectError::File`] with file, line, column and the unknown word or the impossible value.
pub fn load(path: impl AsRef<Path>) -> Result<Vec<&'static dyn AnyEffect>, EffectError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    match pam_data::toml_file::text(path) {
        Ok(text) => read(&text, &file),
        Err(e) => Err(EffectError::File { file, message: e.fault() }),
    }
}

/// The file of the friction models M1 to M6 of a geared drive: `data/effects/friction_ladder.toml`.
pub const FRICTION_LADDER: &str = include_str!("friction_ladder.toml");

/// The friction models M1 to M6 of a geared drive, from Coulomb and viscous friction to one whose parts depend on the loads of
/// both sides and their squares, after Duclusaud, Passault, Padois and Daney (2024).
///
/// # Panics
/// Never: a test reads the file.
#[must_use]
pub fn friction_ladder() -> Vec<&'static dyn AnyEffect> {
    parse(FRICTION_LADDER).expect("the file that comes with the crate")
}

/// As [`load`], from text.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str) -> Result<Vec<&'static dyn AnyEffect>, EffectError> {
    read(text, "effects")
}

/// Effects that live as long as they are kept, for the many that a search tries. Unlike those of [`parse`] they are not the
/// parts of a model: a file would not hold their definition.
///
/// # Errors
/// As [`load`].
pub fn build(text: &str) -> Result<Vec<Box<dyn AnyEffect>>, EffectError> {
    let language = Language::joint();
    let fail = |message: String| EffectError::File { file: "effects".to_owned(), message };
    let definitions =
        EffectDefinition::read_all(text, &language).map_err(|e| fail(e.to_string()))?;
    let effect = |definition: &EffectDefinition| {
        let effect = ExpressionEffect::new(definition, &language, None)
            .map_err(|message| fail(format!("effect `{}`: {message}", definition.id)))?;
        Ok(Box::new(effect) as Box<dyn AnyEffect>)
    };
    definitions.iter().map(effect).collect()
}

/// The effect that a definition in a model file defines.
pub(crate) fn of_definition(id: &str, text: &str) -> Result<&'static dyn AnyEffect, EffectError> {
    let file = format!("definition of `{id}`");
    let effects = read(text, &file)?;
    effects
        .into_iter()
        .find(|e| e.info().id == id)
        .ok_or_else(|| EffectError::File { file, message: "the text defines other effects".into() })
}

fn read(text: &str, file: &str) -> Result<Vec<&'static dyn AnyEffect>, EffectError> {
    let language = Language::joint();
    let fail = |message: String| EffectError::File { file: file.to_owned(), message };
    let definitions =
        EffectDefinition::read_all(text, &language).map_err(|e| fail(e.to_string()))?;
    definitions
        .into_iter()
        .map(|definition| {
            let id = &definition.id;
            if ALL.iter().any(|e| e.info().id == id) {
                return Err(fail(format!(
                    "there is a built-in effect `{id}`; give yours another id"
                )));
            }
            let text = definition.to_toml(&language);
            let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(effect) = known.get(&text) {
                return Ok(*effect as &'static dyn AnyEffect);
            }
            let kept: &'static str = Box::leak(text.clone().into_boxed_str());
            let effect = ExpressionEffect::new(&definition, &language, Some(kept))
                .map_err(|message| fail(format!("effect `{id}`: {message}")))?;
            let effect: &'static ExpressionEffect = Box::leak(Box::new(effect));
            known.insert(text, effect);
            Ok(effect as &'static dyn AnyEffect)
        })
        .collect()
}
