use super::{AnyForce, ForceModel, NetworkForce, SpringDamper};
use crate::activation::ActivationFunction;
use crate::scalar::Scalar;

/// A force model whose numbers can be exchanged, as [`ParametricField`](crate::ParametricField) is for
/// fields.
///
/// The order of the parameters is that in which the model's `map` visits them; for a network layer by
/// layer, the weight matrix column by column, then the bias.
#[diagnostic::on_unimplemented(
    message = "the numbers of the force `{Self}` cannot be exchanged, so that it cannot be trained",
    label = "a force model with parameters is needed here",
    note = "make the force a struct over its scalar and implement `ParametricForce` for the one over `f64`"
)]
pub trait ParametricForce: ForceModel<f64> {
    /// The same model over another scalar.
    type With<S: Scalar>: ForceModel<S>;

    /// The parameters as they are.
    fn parameters(&self) -> Vec<f64>;

    /// Number of parameters.
    fn parameter_len(&self) -> usize {
        self.parameters().len()
    }

    /// The model with other numbers.
    ///
    /// # Panics
    /// If there are not [`parameter_len`](Self::parameter_len) of them.
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S>;
}

impl<F: ParametricForce> ParametricForce for &F {
    type With<S: Scalar> = F::With<S>;
    fn parameters(&self) -> Vec<f64> {
        (**self).parameters()
    }
    fn parameter_len(&self) -> usize {
        (**self).parameter_len()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        (**self).with_parameters(parameters)
    }
}

/// The numbers that a `map` visits, in its order.
fn visited<M>(map: impl FnOnce(&mut dyn FnMut(f64) -> f64) -> M) -> Vec<f64> {
    let mut numbers = Vec::new();
    map(&mut |value| {
        numbers.push(value);
        value
    });
    numbers
}

/// Hands out `parameters` one by one and checks that all are asked for.
fn exchanged<S: Scalar, M>(parameters: &[S], map: impl FnOnce(&mut dyn FnMut(f64) -> S) -> M) -> M {
    let mut rest = parameters.iter();
    let model = map(&mut |_| *rest.next().expect("one number for each parameter"));
    assert!(rest.next().is_none(), "there are more numbers than parameters");
    model
}

macro_rules! parametric_by_map {
    ($([$($generics:tt)*] $type:ident<$($argument:ty),*>);+ $(;)?) => {$(
        impl<$($generics)*> ParametricForce for $type<f64 $(, $argument)*> {
            type With<S: Scalar> = $type<S $(, $argument)*>;
            fn parameters(&self) -> Vec<f64> {
                visited(|visit| self.map(visit))
            }
            fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
                exchanged(parameters, |next| self.map(next))
            }
        }
    )+};
}

parametric_by_map! {
    [A: ActivationFunction] NetworkForce<A>;
    [] SpringDamper<>;
    [] AnyForce<>;
}
