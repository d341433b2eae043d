//! A model at the numbers of one call.

use crate::effects::AnyEffect;
use crate::simulation::Base;
use pam_autodiff::batch::BatchNetwork;

/// Base model, network and effects with the values of one call.
pub(super) struct OperatingModel<'a, T> {
    pub(super) base: Base<f64>,
    /// For values.
    pub(super) plain: &'a BatchNetwork<f64>,
    pub(super) plain_bias: &'a [f64],
    /// For slopes and weights.
    pub(super) network: &'a BatchNetwork<T>,
    pub(super) first_bias: &'a [T],
    pub(super) effects: &'a [&'static dyn AnyEffect],
    /// Parameters and switches of the effects in turn.
    pub(super) values: &'a [f64],
}
