//! Texts and descriptions that stay for the life of the process, each of them once.
//!
//! Descriptions of effects are `'static`, as those of the vocabulary are. A search reads thousands of definitions that differ
//! in their expressions and hardly ever in their descriptions.

use crate::{EffectInfo, ParameterInfo, Switch};
use std::collections::HashSet;
use std::sync::{LazyLock, Mutex, PoisonError};

static TEXTS: LazyLock<Mutex<HashSet<&'static str>>> = LazyLock::new(Mutex::default);

/// A text that stays for the life of the process; equal ones are one.
#[must_use]
pub fn keep(text: &str) -> &'static str {
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = texts.get(text) {
        return known;
    }
    let kept: &'static str = Box::leak(text.to_owned().into_boxed_str());
    texts.insert(kept);
    kept
}

static INFOS: Mutex<Vec<&'static EffectInfo>> = Mutex::new(Vec::new());

/// A description whose texts are kept, kept.
pub(super) fn keep_info(info: KeptTexts<'_>) -> &'static EffectInfo {
    let mut infos = INFOS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = infos.iter().find(|known| info.is(known)) {
        return known;
    }
    let kept: &'static EffectInfo = Box::leak(Box::new(EffectInfo {
        parameters: Box::leak(info.parameters.to_vec().into_boxed_slice()),
        switches: Box::leak(info.switches.to_vec().into_boxed_slice()),
        ..info.texts
    }));
    infos.push(kept);
    kept
}

/// A description with parameters and switches that are not kept yet.
pub(super) struct KeptTexts<'a> {
    /// Everything else.
    pub(super) texts: EffectInfo,
    pub(super) parameters: &'a [ParameterInfo],
    pub(super) switches: &'a [Switch],
}

impl KeptTexts<'_> {
    fn is(&self, known: &EffectInfo) -> bool {
        let EffectInfo { parameters, switches, .. } = *known;
        self.parameters == parameters
            && self.switches == switches
            && EffectInfo { parameters, switches, ..self.texts } == *known
    }
}
