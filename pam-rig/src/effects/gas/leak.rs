//! Chambers that leak.

use crate::effects::{HiddenEffect, Phenomenon, SetUp, entry};

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("leak"),
    typical: &[2e-3, 1e-3],
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
