//! P Vⁿ constant.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("polytropic_gas"),
    typical: &[1.25],
    build: |v| Box::new(PolytropicGas { exponent: v[0] }),
};

struct PolytropicGas {
    exponent: f64,
}

impl Phenomenon for PolytropicGas {
    fn set_up(&self, setup: &mut SetUp) {
        for law in &mut setup.laws {
            law.exponent *= self.exponent;
        }
    }
}
