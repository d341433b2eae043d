//! An effect with its values.

use crate::effects::AnyEffect;

/// An effect that is switched on, with its values: parameters, then switches.
#[derive(Debug, Clone)]
pub struct ActiveEffect {
    /// The effect.
    pub effect: &'static dyn AnyEffect,
    /// Its values.
    pub values: Vec<f64>,
}

impl ActiveEffect {
    /// Its parameters, without the switches.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.values[..self.effect.info().parameters.len()]
    }

    /// The effects, and all their values in turn, as a [simulation](crate::simulation::simulate) takes them.
    #[must_use]
    pub fn split(effects: &[Self]) -> (Vec<&'static dyn AnyEffect>, Vec<f64>) {
        let values = effects.iter().flat_map(|active| active.values.iter().copied());
        (effects.iter().map(|active| active.effect).collect(), values.collect())
    }

    /// These effects with other parameters, which follow each other in the order of the effects.
    ///
    /// # Panics
    /// If there are fewer parameters than the effects have.
    #[must_use]
    pub fn with_parameters(effects: &[Self], parameters: &[f64]) -> Vec<Self> {
        let mut rest = parameters;
        effects
            .iter()
            .map(|active| {
                let mut active = active.clone();
                let (own, next) = rest.split_at(active.parameters().len());
                active.values[..own.len()].copy_from_slice(own);
                rest = next;
                active
            })
            .collect()
    }
}
