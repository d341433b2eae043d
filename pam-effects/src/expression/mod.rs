//! Effects as expressions: compiled, differentiated, evaluated with any scalar.
//!
//! [`load`] reads a file of effects (the format is [`pam_vocabulary::definition`]'s) and gives effects that a diagnosis
//! takes as candidates, a model as parts, and [`register`](crate::effects::register) makes known by their ids:
//!
//! ```
//! use pam_effects::{ActiveEffect, expression};
//!
//! let text = r#"
//! [[effect]]
//! id = "hardening_spring"
//! description = "spring that hardens"
//! parameters.stiffness_n_mm3 = { range = [0, 10], absent = 0 }
//! acts.force_n = "-stiffness_n_mm3 * x^3"
//! "#;
//! let effects = expression::parse(text)?;
//! let active = ActiveEffect { effect: effects[0], values: vec![0.2] };
//! assert_eq!(active.effect.info().id, "hardening_spring");
//! # Ok::<(), pam_effects::EffectError>(())
//! ```
//!
//! An expression becomes a graph in which equal parts are one node, and that a flat program over a few registers.
//! Nothing is allocated in a step. [`Compiled`] is such a program over any named numbers, for vector fields of all kinds.

mod compiled;
mod effect;
mod graph;
mod joint;
mod library;
mod memory;
mod program;

pub use compiled::Compiled;
pub use library::{load, parse};

pub(crate) use library::of_definition;
