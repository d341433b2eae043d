//! P Vⁿ constant.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "polytropic_gas",
    group: Group::Gas,
    what: "the pressure follows Vⁿ instead of V (P Vⁿ = const where the air is isothermal)",
    parameters: &[ParameterInfo::new("exponent", 1.25, [0.5, 2.0])],
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
