//! Force models: what the joint's muscles do, as a restoring force `f(x, ẋ, m_f, m_e)`.
//!
//! A force model is anything that implements [`ForceModel`]. To add one that files and commands
//! know by name, write its file with [`StoredForce`] and [`ForceModel`], and add one line to the
//! list of [`AnyForce`].

mod any;
mod input;
pub mod mlp;
mod network;
mod parametric;
mod spring_damper;
mod stored;

pub use any::AnyForce;
pub use input::ForceInput;
pub use mlp::{Dense, Mlp};
pub use network::NetworkForce;
pub use parametric::ParametricForce;
pub use spring_damper::SpringDamper;
pub use stored::{ForceParts, StoredForce, Tensor};

use crate::scalar::Scalar;

/// A scalar restoring force of the joint, in mN.
///
/// **Sign.** The value is positive where the muscles pull back towards negative `x`. It enters the
/// dynamics with a minus, `m ẍ = F_e − f − B ẋ`; a stable joint has `∂f/∂x > 0`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no force model over `{S}`",
    label = "a restoring force over `{S}` is needed here",
    note = "implement `ForceModel<S>` for it with `impl<S: Scalar>`; for derivatives pass it with dual \
            numbers, for example `model.force.map(Dual64::constant)`"
)]
pub trait ForceModel<S: Scalar> {
    /// The restoring force in mN at one operating point. `work` holds at least
    /// [`work_len`](ForceModel::work_len) scalars of any content; nothing is allocated.
    fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S;

    /// Number of scratch scalars that one evaluation needs.
    fn work_len(&self) -> usize {
        0
    }

    /// The layers, if the force is a (leaky) ReLU network with the inputs `(m_f, m_e, x, ẋ)` and at
    /// least one hidden layer: it is then piecewise affine, and exact methods apply.
    fn relu_layers(&self) -> Option<ReluLayers<'_, S>> {
        None
    }

    /// The network, if the force is one with an [`Activation`](crate::Activation): many points are then evaluated at once.
    fn network(&self) -> Option<&NetworkForce<S>> {
        None
    }
}

/// A network with the activation `max(z, slope · z)` after every layer but the last.
#[derive(Debug, Clone, Copy)]
pub struct ReluLayers<'a, S> {
    /// The layers, first to last.
    pub layers: &'a [Dense<S>],
    /// The slope for negative `z`, from 0 to 1.
    pub slope: f64,
}

impl<S: Scalar, F: ForceModel<S> + ?Sized> ForceModel<S> for &F {
    fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S {
        (**self).restoring_force_mn(input, work)
    }
    fn work_len(&self) -> usize {
        (**self).work_len()
    }
    fn relu_layers(&self) -> Option<ReluLayers<'_, S>> {
        (**self).relu_layers()
    }
    fn network(&self) -> Option<&NetworkForce<S>> {
        (**self).network()
    }
}

impl<S: Scalar, F: ForceModel<S> + ?Sized> ForceModel<S> for Box<F> {
    fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S {
        (**self).restoring_force_mn(input, work)
    }
    fn work_len(&self) -> usize {
        (**self).work_len()
    }
    fn relu_layers(&self) -> Option<ReluLayers<'_, S>> {
        (**self).relu_layers()
    }
    fn network(&self) -> Option<&NetworkForce<S>> {
        (**self).network()
    }
}
