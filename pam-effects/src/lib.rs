//! Effects as parts of a model.
//!
//! An entry of the vocabulary of known effects ([`effects`]) is a term with parameters that carry units: a force,
//! a law of the air, a memory, a sensor. An [`ExtendedModel`] is a hybrid model with such terms; it predicts
//! recordings, has gradients, and is saved and loaded like a model without them.
//!
//! # Modules, in reading order
//!
//! 1. [`effects`]: one file per effect, and the hooks through which an effect acts.
//! 2. [`simulation`]: a resampled recording, the table of the base model's force, the integrator over any scalar.
//! 3. [`model`]: the model with effects: prediction and files.
//! 4. [`expression`]: effects that a file defines by expressions.
//! 5. [`engine`]: the exact gradient by weights and effects together, and the choice of an engine for any model.

pub mod effects;
pub mod engine;
pub mod error;
pub mod expression;
pub mod model;
pub mod simulation;

pub use engine::{EngineChoice, choose};
pub use error::EffectError;
pub use model::{ActiveEffect, EffectRecord, ExtendedModel, WithoutEffects};
