//! The model of an antagonistic pair of pneumatic artificial muscles (PAMs), written once for
//! every scalar type.
//!
//! The crate reads from the bottom up:
//!
//! 1. [`scalar`]: the number types a model can run with (`f32`, `f64`, dual numbers, later a
//!    reverse-mode variable);
//! 2. [`field`]: what a vector field `ẏ = f(t, y, u)` is;
//! 3. [`activation`] and [`force`]: the learned part, a *restoring* force `f_θ(x, ẋ, m_f, m_e)`;
//! 4. [`joint`]: geometry, gas and mechanics, and the hybrid vector field that joins them.
//!
//! # Units
//!
//! Everything is in mm, mm/s, kPa absolute, g, mN, kg and s. Because 1 kg·mm/s² = 1 mN, no
//! conversion factor appears in `m ẍ = F`. A stiffness in mN/mm divided by 1000 is N/mm. Bare
//! numbers that cross the border of the code carry their unit in their name (`force_n`,
//! `pressure_kpa`).
//!
//! # Sign of the learned force
//!
//! The learned force is the *restoring* force: positive for `x > 0` in a joint that springs back,
//! and it enters with a minus, `m ẍ = F_e − f_θ − B ẋ`. Hence stiffness `K = ∂f_θ/∂x` and damping
//! `∂f_θ/∂ẋ` are positive for a stable joint. (Wang and Realmuto write `m ẍ = F_e + f_θ` together
//! with `K = ∂f_θ/∂x > 0`, which cannot both hold; their published code and weights follow the
//! convention used here.)

pub mod activation;
pub mod choice;
pub mod error;
pub mod field;
pub mod force;
pub mod joint;
pub mod latest;
pub mod parallel;
pub mod scalar;
pub mod settings;
pub mod simd;
pub mod units;

pub use activation::{Activation, ActivationFunction};
pub use choice::NamedChoice;
pub use error::ModelError;
pub use field::{DryFriction, FieldFn, FieldNames, ParametricField, VectorField};
pub use force::{
    AnyForce, ForceInput, ForceModel, ForceParts, Mlp, NetworkForce, ParametricForce, ReluLayers,
    SpringDamper, StoredForce,
};
pub use joint::{
    Chambers, JointField, JointModel, MuscleGeometry, PhysicalParameters, RawParameters,
    SealedMasses,
};
pub use latest::Latest;
pub use scalar::{Scalar, smooth_step};
