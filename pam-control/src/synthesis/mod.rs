//! Inverse synthesis: from a desired motion and stiffness to air masses and pressures.
//!
//! - [`problem`]: targets, bounds, settings, solutions;
//! - [`batch`]: forces and their slopes for many points at once;
//! - [`solver`]: the structured solver, [`Synthesiser`];
//! - [`certified`]: the global optimum with a proof, [`CertifiedSynthesiser`];
//! - [`plan`]: a whole trajectory with its pressure commands, [`Plan`].
//!
//! Inside: the stencil of K̂, Newton's method on batched segments, and the curve of dynamically consistent masses,
//! followed piece by piece.

pub mod batch;
pub mod certified;
mod landscape;
mod newton;

pub mod plan;
pub mod problem;
mod relu_stencil;
pub mod solver;
mod stencil;
mod trace;
mod walk;

pub use batch::{AnyBatch, ForceBatch, NetworkBatch, Pointwise};
pub use certified::CertifiedSynthesiser;
pub use plan::{Plan, PlanSummary};
pub use problem::{MassBounds, Outcome, Solution, SynthesisSettings, TRAINED_KPA, Target};
pub use solver::Synthesiser;
