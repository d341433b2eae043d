//! Effects in a simulation.

use crate::effects::{AnyEffect, EffectHooks, EffectScalar, Hooks};
use std::ops::Range;

/// An effect with its values in a simulation, and where its memory lies.
pub(crate) struct Part<'a, S> {
    pub(crate) effect: &'a dyn EffectHooks<S>,
    /// The hooks that it has.
    pub(super) hooks: Hooks,
    /// Whether there may be dry friction later.
    pub(super) may_stick_later: bool,
    pub(crate) p: &'a [S],
    pub(super) memory: Range<usize>,
}

/// The effects that act on one joint, with their values.
pub(crate) struct Parts<'a, S> {
    pub(crate) list: Vec<Part<'a, S>>,
    pub(super) memory_len: usize,
    /// The hooks that any of them has.
    pub(super) hooks: Hooks,
    /// Whether one of them changes the gas law.
    pub(super) air: bool,
    /// Whether inertia, delay or gas law of one of them depend on the time.
    pub(super) changes_in_time: bool,
}

impl<'a, S: EffectScalar> Parts<'a, S> {
    /// Effects in the order in which they act; `values` holds the parameters and switches of each in turn.
    pub(crate) fn new(effects: &[&'a dyn AnyEffect], values: &'a [S]) -> Self {
        let (mut first_value, mut memory_len) = (0, 0);
        let list = effects
            .iter()
            .map(|e| {
                let (v, m) = (e.info().value_len(), e.memory_len());
                let p = &values[first_value..first_value + v];
                let real: Vec<f64> = p.iter().map(|value| value.real()).collect();
                let part = Part {
                    effect: S::hooks(*e),
                    hooks: e.hooks(),
                    may_stick_later: e.may_stick_later(&real),
                    p,
                    memory: memory_len..memory_len + m,
                };
                first_value += v;
                memory_len += m;
                part
            })
            .collect();
        Self {
            list,
            hooks: effects.iter().fold(Hooks::NONE, |all, e| all.or(e.hooks())),
            memory_len,
            air: effects.iter().any(|e| e.changes_gas()),
            changes_in_time: effects.iter().any(|e| e.changes_in_time()),
        }
    }
}
