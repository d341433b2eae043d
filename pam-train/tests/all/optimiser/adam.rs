use pam_train::optimiser::{Adam, AdamSettings};

/// The first step has the length of the rate in every coordinate, whatever the gradient's scale.
#[test]
fn the_first_step_is_the_rate() {
    let mut adam = Adam::new(AdamSettings::default(), 2);
    let mut at = [1.0, 1.0];
    adam.step(&mut at, &[1e-3, -50.0], 0.1);
    assert!((at[0] - 0.9).abs() < 1e-5 && (at[1] - 1.1).abs() < 1e-8);
}

#[test]
fn it_finds_the_minimum_of_a_bad_quadratic() {
    let mut adam = Adam::new(AdamSettings::default(), 2);
    let mut at = [3.0, -2.0];
    for k in 0..4000 {
        let g = [2.0 * at[0], 2e4 * at[1]];
        adam.step(&mut at, &g, 0.05 / (1.0 + f64::from(k) / 100.0));
    }
    assert!(at.iter().all(|x| x.abs() < 1e-3), "{at:?}");
}

#[test]
fn weight_decay_is_apart_from_the_gradient() {
    let settings = AdamSettings { weight_decay: 0.1, ..AdamSettings::default() };
    let mut adam = Adam::new(settings, 1);
    let mut at = [2.0];
    adam.step(&mut at, &[0.0], 0.5);
    assert!((at[0] - 1.9).abs() < 1e-15);
}
