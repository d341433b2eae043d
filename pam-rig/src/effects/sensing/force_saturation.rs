//! The real force is clipped.

use crate::effects::{Clock, EffectInfo, Group, ParameterInfo, Phenomenon};

/// The effect.
pub const INFO: EffectInfo = EffectInfo {
    id: "force_saturation",
    group: Group::Sensing,
    what: "real force is clipped at ± force_n",
    parameters: &[ParameterInfo::new("force_n", 160.0, [0.0, 1e4])],
    build: |v| Box::new(ForceSaturation { force_n: v[0] }),
};

struct ForceSaturation {
    force_n: f64,
}

impl Phenomenon for ForceSaturation {
    fn actuate(&mut self, _clock: &Clock, force_n: f64) -> f64 {
        force_n.clamp(-self.force_n, self.force_n)
    }
}
