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
//! [`pam_expression`] compiles the expressions; other vector fields take them as its [`Terms`](pam_expression::Terms).

mod at_zero;
mod effect;
mod joint;
mod library;
mod memory;
mod sensing;

pub use library::{FRICTION_LADDER, build, friction_ladder, load, parse};

pub(crate) use library::of_definition;
