use approx::assert_relative_eq;
use num_dual::Dual64;
use pam_core::Activation;
use pam_core::ActivationFunction;

/// Values from the definitions, computed with an independent program to 12 digits.
#[test]
fn values_match_the_definitions() {
    let expected = [
        ("leaky_relu", -0.013, 0.7),
        ("relu", 0.0, 0.7),
        ("tanh", -0.861_723_159_313, 0.604_367_777_117),
        ("softplus", 0.241_008_453_833, 1.103_186_048_885),
        ("silu", -0.278_414_522_045, 0.467_731_440_518),
        ("gelu", -0.126_070_987_683, 0.530_570_134_705),
        ("elu", -0.727_468_206_966, 0.7),
        ("sine", -0.963_558_185_417, 0.644_217_687_238),
    ];
    for (name, at_negative, at_positive) in expected {
        let a = Activation::from_name(name).unwrap();
        assert_eq!(a.name(), name);
        assert_relative_eq!(a.value(-1.3_f64), at_negative, max_relative = 2e-11);
        assert_relative_eq!(a.value(0.7_f64), at_positive, max_relative = 2e-11);
    }
}

#[test]
fn derivatives_match_central_differences() {
    for name in Activation::NAMES {
        let a = Activation::from_name(name).unwrap();
        for z in [-3.1, -0.4, 0.3, 2.2] {
            let h = 1e-6;
            let fd = (a.value(z + h) - a.value(z - h)) / (2.0 * h);
            let exact = a.value(Dual64::new(z, 1.0)).eps;
            assert_relative_eq!(exact, fd, epsilon = 1e-9, max_relative = 1e-8);
        }
    }
}

/// The batch forms equal the generic ones, values and slopes, for both floats.
#[test]
fn batches_match_the_generic_functions() {
    let points: Vec<f64> = (-400..=400).map(|k| f64::from(k) * 0.0317 + 1e-3).collect();
    for name in Activation::NAMES {
        let a = Activation::from_name(name).unwrap();
        let (mut z, mut slopes) = (points.clone(), vec![0.0; points.len()]);
        a.apply_to_batch_with_slopes(&mut z, &mut slopes);
        let mut z32: Vec<f32> = points.iter().map(|&p| p as f32).collect();
        let mut slopes32 = vec![0.0; points.len()];
        a.apply_to_batch_with_slopes(&mut z32, &mut slopes32);
        let mut values = points.clone();
        a.apply_to_batch(&mut values);
        assert_eq!(values, z);
        for (i, &p) in points.iter().enumerate() {
            let exact = a.value(Dual64::new(p, 1.0));
            assert_relative_eq!(z[i], exact.re, epsilon = 1e-15, max_relative = 1e-14);
            assert_relative_eq!(slopes[i], exact.eps, epsilon = 1e-14, max_relative = 1e-13);
            assert!(
                (f64::from(z32[i]) - exact.re).abs() < 3e-6 * (1.0 + exact.re.abs()),
                "{name} {p}"
            );
            assert!((f64::from(slopes32[i]) - exact.eps).abs() < 5e-6, "{name} {p}");
        }
    }
}

#[test]
fn nothing_overflows_far_out() {
    for name in Activation::NAMES {
        let a = Activation::from_name(name).unwrap();
        for z in [-1e4, 1e4] {
            let d = a.value(Dual64::new(z, 1.0));
            assert!(d.re.is_finite() && d.eps.is_finite(), "{name} at {z}: {d}");
        }
    }
}

#[test]
fn parameters_survive_as_json() {
    for name in Activation::NAMES {
        let a = Activation::from_name(name).unwrap();
        assert_eq!(Activation::from_name_and_json(name, &a.parameters_json()).unwrap(), a);
    }
    let steep = Activation::from_name_and_json("leaky_relu", r#"{"slope":0.2}"#).unwrap();
    assert_eq!(steep.value(-1.0_f64), -0.2);
    assert!(Activation::from_name_and_json("leaky_relu", r#"{"angle":0.2}"#).is_err());
}

#[test]
fn unknown_names_list_the_known_ones() {
    let message = Activation::from_name("swoosh").unwrap_err().to_string();
    assert!(message.contains("swoosh") && message.contains("leaky_relu"));
}
