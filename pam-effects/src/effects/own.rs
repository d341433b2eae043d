//! Effects of other crates that files and command lines know by their ids.

use super::{ALL, AnyEffect};
use crate::error::EffectError;
use std::sync::{PoisonError, RwLock};

/// Effects of [`by_id`](super::by_id) and [`all`] other than [`ALL`]. Entries are added and never replaced.
static REGISTERED: RwLock<Vec<&'static dyn AnyEffect>> = RwLock::new(Vec::new());

/// Makes an effect known by its id to everything in this process that reads ids: model files, curricula, sweeps, options
/// and the candidates of a diagnosis. To do so twice is no error.
///
/// # Errors
/// [`EffectError::Effect`] if another effect has the id.
pub fn register(effect: &'static dyn AnyEffect) -> Result<(), EffectError> {
    let info = effect.info();
    let taken = |what: &str| EffectError::Effect {
        id: info.id.to_owned(),
        message: format!("there is {what} with this id already; give yours another id"),
    };
    if ALL.iter().any(|e| e.info().id == info.id) {
        return Err(taken("a built-in effect"));
    }
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    match registered.iter().find(|e| e.info().id == info.id) {
        Some(known) if known.info() == info && known.definition() == effect.definition() => {}
        Some(_) => return Err(taken("another effect")),
        None => registered.push(effect),
    }
    Ok(())
}

/// The effects that were [registered](register), in that order.
#[must_use]
pub fn registered() -> Vec<&'static dyn AnyEffect> {
    REGISTERED.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Every effect: the built-in ones, then those that were [registered](register).
#[must_use]
pub fn all() -> Vec<&'static dyn AnyEffect> {
    ALL.iter().copied().chain(registered()).collect()
}
