//! Requests for loss and gradient of a model with further parts.

use super::sealed::IndexedLoss;
use super::{JointGradient, NetworkJoint};
use crate::windows::Windows;
use std::fmt::Debug;

/// Loss and gradient of a model with an extension, again and again for changing numbers.
pub trait ExtendedGradient: Debug + Send {
    /// Value and gradient of the mean loss over windows, each predicted from its own start. With
    /// `backward` off the gradient is of no meaning. The same bits at any number of threads.
    fn value_and_gradient(
        &mut self,
        at: &ExtendedRequest<'_>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> JointGradient;

    /// Predicted states of the `index`-th window of the last call, at its samples.
    fn predicted(&self, index: usize) -> &[[f64; 4]];
}

/// What loss and gradient are asked for.
#[derive(Debug, Clone, Copy)]
pub struct ExtendedRequest<'a> {
    /// The model without its extension.
    pub model: &'a NetworkJoint,
    /// The extension's numbers.
    pub values: &'a [f64],
    /// All windows.
    pub windows: &'a Windows,
    /// Those that are asked for.
    pub part: &'a [usize],
    /// Their starts `[x, ẋ, P_f, P_e]` as measured (mm, mm/s, kPa, kPa).
    pub starts: &'a [[f64; 4]],
}
