//! Dry friction of gearbox and joint with sticking.

use serde::{Deserialize, Serialize};

/// Dry friction: `coulomb_n` when sliding, up to `static_n` at rest, with Stribeck's decay between,
///
/// ```text
/// |F(v)| = coulomb + (static − coulomb) exp(−(v/v_s)²)
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DryFriction {
    /// Force while sliding fast, N.
    pub coulomb_n: f64,
    /// Force to break away, N.
    pub static_n: f64,
    /// Stribeck's velocity v_s, mm/s.
    pub velocity_mm_s: f64,
}

/// Gearbox and bearings, seen at the tendon; calibrated, see `docs/rig.md`.
impl Default for DryFriction {
    fn default() -> Self {
        Self { coulomb_n: 18.0, static_n: 21.0, velocity_mm_s: 1.0 }
    }
}

impl DryFriction {
    /// Plain Coulomb friction.
    #[must_use]
    pub fn coulomb(force_n: f64) -> Self {
        Self { coulomb_n: force_n, static_n: force_n, velocity_mm_s: 1.0 }
    }

    /// Largest force at a speed, N.
    #[must_use]
    pub fn limit_n(&self, velocity_mm_s: f64) -> f64 {
        if self.static_n == self.coulomb_n {
            return self.coulomb_n;
        }
        let ratio = velocity_mm_s / self.velocity_mm_s;
        self.coulomb_n + (self.static_n - self.coulomb_n) * (-ratio * ratio).exp()
    }
}

/// The velocity after a step with set-valued friction, `v̇ ∈ a − Sgn(v) · limit` (Moreau 1988).
///
/// `before` is the velocity at the start, `change` what the other forces would add to it in the step,
/// `sliding` and `breaking` the changes that the friction's force while sliding and at rest could
/// make. A joint that comes to rest within the step is weighed there against the breaking force: it
/// stays at exactly zero, or goes on with what is left of the step.
#[must_use]
pub fn after_friction(before: f64, change: f64, sliding: f64, breaking: f64) -> f64 {
    let mut left = 1.0;
    if before != 0.0 {
        let along = change * before.signum() - sliding;
        if along >= -before.abs() {
            return before + along * before.signum();
        }
        left = 1.0 + before.abs() / along;
    }
    if change.abs() <= breaking {
        return 0.0;
    }
    left * (change - sliding.copysign(change))
}
