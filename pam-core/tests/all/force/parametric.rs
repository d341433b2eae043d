use pam_core::activation::Tanh;
use pam_core::force::Dense;
use pam_core::{Mlp, NetworkForce, ParametricForce, SpringDamper};

#[test]
fn parameters_survive_the_round_trip() {
    let rows: Vec<f64> = (0..12).map(f64::from).collect();
    let layers = vec![
        Dense::from_rows(&rows, vec![20.0, 21.0, 22.0]).unwrap(),
        Dense::from_rows(&[30.0, 31.0, 32.0], vec![40.0]).unwrap(),
    ];
    let force = NetworkForce::new(Mlp::new(layers, Tanh).unwrap()).unwrap();
    let parameters = ParametricForce::parameters(&force);
    assert_eq!(parameters.len(), force.mlp().parameter_count());
    assert_eq!(parameters[..4], [0.0, 4.0, 8.0, 1.0], "columns first");
    assert_eq!(force.with_parameters(&parameters), force);
    let spring = SpringDamper::constant(150e3, 6500.0);
    assert_eq!(spring.with_parameters(&ParametricForce::parameters(&spring)), spring);
}

#[test]
#[should_panic(expected = "more numbers")]
fn too_many_numbers_are_refused() {
    let spring = SpringDamper::constant(150e3, 6500.0);
    let _ = spring.with_parameters(&[0.0_f64; 99]);
}
