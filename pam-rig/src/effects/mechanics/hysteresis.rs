//! A rate-independent loop with memory.

use crate::effects::{Clock, HiddenEffect, Phenomenon, entry};
use crate::plant::Plant;

/// The effect.
pub const EFFECT: HiddenEffect = HiddenEffect {
    info: entry("hysteresis"),
    typical: &[20.0, 0.5],
    build: |v| {
        Box::new(Hysteresis {
            force_n: v[0],
            slip_mm: v[1],
            last_mm: None,
            elements: [0.0; ELEMENTS],
        })
    },
};

const ELEMENTS: usize = 20;

/// Elements of equal limit whose slip distances are spread evenly from 0 to `slip_mm`.
struct Hysteresis {
    force_n: f64,
    slip_mm: f64,
    last_mm: Option<f64>,
    elements: [f64; ELEMENTS],
}

impl Phenomenon for Hysteresis {
    fn joint_force_n(&mut self, _clock: &Clock, plant: &Plant) -> f64 {
        let now = plant.displacement_mm();
        let travel = now - self.last_mm.replace(now).unwrap_or(now);
        let limit = self.force_n / ELEMENTS as f64;
        for (j, z) in self.elements.iter_mut().enumerate() {
            let slip_mm = self.slip_mm * (j as f64 + 0.5) / ELEMENTS as f64;
            *z = (*z + limit / slip_mm * travel).clamp(-limit, limit);
        }
        -self.elements.iter().sum::<f64>()
    }
}
