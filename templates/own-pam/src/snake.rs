//! An activation: Snake (L. Ziyin, T. Hartwig and M. Ueda, *Neural Networks Fail to Learn Periodic Functions*, 2020).

use pam_cli::own::{ActivationFunction, NamedActivation, Scalar};
use serde::{Deserialize, Serialize};

/// `z + sin²(a z) / a`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Snake {
    /// `a`, which model files keep.
    pub frequency: f64,
}

/// What the name alone stands for.
pub const SNAKE: Snake = Snake { frequency: 1.0 };

impl ActivationFunction for Snake {
    fn value<S: Scalar>(&self, z: S) -> S {
        let sine = z.scaled(self.frequency).sin();
        z + (sine * sine).scaled(1.0 / self.frequency)
    }
}

impl NamedActivation for Snake {
    const NAME: &'static str = "snake";
}
