//! Activations of other crates: values and derivatives of any number are those of their own code.

use approx::assert_relative_eq;
use num_dual::{Dual, Dual2, Dual3, Dual64, HyperDual64, HyperHyperDual};
use pam_core::activation::{ChosenActivation, NamedActivation, register};
use pam_core::{Activation, ActivationFunction, ModelError, Scalar};
use serde::{Deserialize, Serialize};

/// `z + sin²(a z) / a`, whose derivatives are known: `1 + sin 2az`, `2a cos 2az`, `−4a² sin 2az`, …
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Snake {
    a: f64,
}

impl ActivationFunction for Snake {
    fn value<S: Scalar>(&self, z: S) -> S {
        let s = z.scaled(self.a).sin();
        z + (s * s).scaled(1.0 / self.a)
    }
}

impl NamedActivation for Snake {
    const NAME: &'static str = "snake_of_the_tests";
}

/// Another one with the same name.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Impostor;

impl ActivationFunction for Impostor {
    fn value<S: Scalar>(&self, z: S) -> S {
        z
    }
}

impl NamedActivation for Impostor {
    const NAME: &'static str = Snake::NAME;
}

/// One with a name that is taken from the beginning.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct SecondTanh;

impl ActivationFunction for SecondTanh {
    fn value<S: Scalar>(&self, z: S) -> S {
        z.tanh()
    }
}

impl NamedActivation for SecondTanh {
    const NAME: &'static str = "tanh";
}

#[test]
fn every_number_gets_the_derivatives_of_the_own_code() {
    let (a, z) = (1.3, 0.7_f64);
    let own = register(&Snake { a }).unwrap();
    let derivative = [
        z + (a * z).sin().powi(2) / a,
        1.0 + (2.0 * a * z).sin(),
        2.0 * a * (2.0 * a * z).cos(),
        -4.0 * a * a * (2.0 * a * z).sin(),
        -8.0 * a.powi(3) * (2.0 * a * z).cos(),
    ];
    let close = |x: f64, y: f64| assert_relative_eq!(x, y, max_relative = 1e-13);
    close(own.value(z), derivative[0]);
    close(own.value(Dual64::new(z, 2.0)).eps, 2.0 * derivative[1]);
    let second = own.value(Dual2::<f64>::new(z, 1.0, 0.5));
    close(second.v2, derivative[2] + 0.5 * derivative[1]);
    close(own.value(HyperDual64::new(z, 1.0, 1.0, 0.0)).eps1eps2, derivative[2]);
    close(own.value(Dual3::<f64>::new(z, 1.0, 0.0, 0.0)).v3, derivative[3]);
    let mixed = HyperHyperDual::<f64>::new(z, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0);
    close(own.value(mixed).eps1eps2eps3, derivative[3]);
    // Nested numbers carry higher ones.
    let one = Dual64::new(1.0, 0.0);
    let none = Dual64::new(0.0, 0.0);
    let fourth = own.value(Dual3::new(Dual64::new(z, 1.0), one, none, none));
    close(fourth.v3.eps, derivative[4]);
    let float = own.value(Dual::<f32>::new(z as f32, 1.0));
    assert!((f64::from(float.eps) - derivative[1]).abs() < 1e-6);
    let (mut values, mut slopes) = ([z; 11], [0.0; 11]);
    own.apply_to_batch_with_slopes(&mut values, &mut slopes);
    close(values[10], derivative[0]);
    close(slopes[10], derivative[1]);
}

#[test]
fn names_mean_one_thing_and_parameters_are_kept() {
    let own = register(&Snake { a: 1.3 }).unwrap();
    assert_eq!(register(&Snake { a: 1.3 }).unwrap(), own);
    assert_eq!(Activation::from_name(Snake::NAME).unwrap(), own);
    assert!(Activation::names().contains(&Snake::NAME));
    let other = Activation::from_name_and_json(Snake::NAME, r#"{"a":2.0}"#).unwrap();
    assert_ne!(other, own);
    assert_eq!(other.value(0.4_f64), Snake { a: 2.0 }.value(0.4));
    assert_eq!(Activation::from_name_and_json(Snake::NAME, &own.parameters_json()).unwrap(), own);
    assert!(Activation::from_name_and_json(Snake::NAME, r#"{"b":2.0}"#).is_err());
    for taken in [register(&Impostor), register(&Snake { a: 3.0 }), SecondTanh.choose()] {
        assert!(matches!(taken, Err(ModelError::NameTaken { .. })), "{taken:?}");
    }
    let message = Activation::from_name("swoosh").unwrap_err().to_string();
    assert!(message.contains("pam_cli::Registry"), "{message}");
}
