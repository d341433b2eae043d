//! Chambers that leak.

use crate::effects::{EffectInfo, Group, ParameterInfo, Phenomenon, SetUp};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "leak",
    group: Group::Gas,
    what: "chambers leak: ṁ = −rate · m (P − P_atm)/P",
    parameters: &[
        ParameterInfo::new("flexor_rate_per_s", 2e-3, [0.0, 10.0]).or(0.0),
        ParameterInfo::new("extensor_rate_per_s", 1e-3, [0.0, 10.0]).or(0.0),
    ],
    build: |v| Box::new(Leak { rate_per_s: [v[0], v[1]] }),
};

struct Leak {
    rate_per_s: [f64; 2],
}

impl Phenomenon for Leak {
    fn set_up(&self, setup: &mut SetUp) {
        for (rate, more) in setup.plant.leak_per_s.iter_mut().zip(self.rate_per_s) {
            *rate += more;
        }
    }
}
