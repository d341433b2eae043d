//! Adam and AdamW.

use serde::{Deserialize, Serialize};

/// Settings of Adam (Kingma and Ba 2015); with a weight decay AdamW (Loshchilov and Hutter 2019).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AdamSettings {
    /// Decay of the mean of gradients.
    pub beta1: f64,
    /// Decay of the mean of squared gradients.
    pub beta2: f64,
    /// Added to the root of the latter.
    pub epsilon: f64,
    /// Share by which coordinates shrink in a step of rate one, apart from the gradient.
    pub weight_decay: f64,
}

impl Default for AdamSettings {
    fn default() -> Self {
        Self { beta1: 0.9, beta2: 0.999, epsilon: 1e-8, weight_decay: 0.0 }
    }
}

/// Adam in operation:
///
/// ```text
/// m ← β₁ m + (1 − β₁) g,   v ← β₂ v + (1 − β₂) g²
/// θ ← θ − rate · [ m/(1 − β₁ᵗ) / (√(v/(1 − β₂ᵗ)) + ε) + decay · θ ]
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    /// Settings.
    pub settings: AdamSettings,
    steps: u64,
    mean: Vec<f64>,
    square: Vec<f64>,
}

impl Adam {
    /// True if it is for so many coordinates.
    #[cfg(feature = "joint")]
    pub(crate) fn fits(&self, len: usize) -> bool {
        self.mean.len() == len && self.square.len() == len
    }

    /// Adam for `len` coordinates.
    #[must_use]
    pub fn new(settings: AdamSettings, len: usize) -> Self {
        Self { settings, steps: 0, mean: vec![0.0; len], square: vec![0.0; len] }
    }

    /// Moves `at` by one step.
    ///
    /// # Panics
    /// If lengths differ.
    pub fn step(&mut self, at: &mut [f64], gradient: &[f64], rate: f64) {
        assert_eq!((at.len(), gradient.len()), (self.mean.len(), self.mean.len()));
        let AdamSettings { beta1, beta2, epsilon, weight_decay } = self.settings;
        self.steps += 1;
        let t = i32::try_from(self.steps).unwrap_or(i32::MAX);
        let (per_c1, per_c2) = ((1.0 - beta1.powi(t)).recip(), (1.0 - beta2.powi(t)).recip());
        for (((x, &g), m), v) in
            at.iter_mut().zip(gradient).zip(&mut self.mean).zip(&mut self.square)
        {
            *m = beta1 * *m + (1.0 - beta1) * g;
            *v = beta2 * *v + (1.0 - beta2) * g * g;
            *x -= rate * (*m * per_c1 / ((*v * per_c2).sqrt() + epsilon) + weight_decay * *x);
        }
    }
}
