use pam_core::Activation;
use pam_train::warm_start::{Initialisation, random_network};

#[test]
fn weights_have_the_spread_that_keeps_activations_alive() {
    let relu = Activation::from_name("relu").unwrap();
    let force = random_network(&[400, 400], relu, Initialisation::He, 1).unwrap();
    let layer = &force.mlp().layers()[1];
    let weights = layer.weight_columns();
    let square = weights.iter().map(|w| w * w).sum::<f64>() / weights.len() as f64;
    assert!((square * 400.0 - 2.0).abs() < 0.05, "variance 2/inputs: {square}");
    assert!(layer.bias().iter().all(|b| *b == 0.0));
}

#[test]
fn the_seed_decides() {
    let relu = Activation::from_name("relu").unwrap();
    let draw = |seed| random_network(&[8], relu, Initialisation::InverseRoot, seed).unwrap();
    assert_eq!(draw(3), draw(3));
    assert_ne!(draw(3), draw(4));
    assert!(random_network(&[0], relu, Initialisation::He, 1).is_err());
}
