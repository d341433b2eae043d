//! Sampled inputs between their samples, their jumps and the products of their Jacobians.

use pam_solvers::input::InputError;
use pam_solvers::{Input, Interpolation, ParametricInput, SampledInput, Side};

fn at(input: &SampledInput<'_, f64>, t: f64, side: Side) -> f64 {
    let mut u = [0.0];
    input.value_into(t, side, &mut u);
    u[0]
}

#[test]
fn a_hold_keeps_the_left_value_up_to_the_sample() {
    let times: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.001).collect();
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    for k in 1..100 {
        assert_eq!(at(&input, times[k], Side::Left), values[k - 1]);
        assert_eq!(at(&input, times[k], Side::Right), values[k]);
        assert_eq!(at(&input, times[k] - 4e-4, Side::Right), values[k - 1]);
        assert_eq!(input.next_jump(times[k - 1]), Some(times[k]));
    }
    assert_eq!(input.next_jump(times[99]), None);
    assert_eq!(input.next_jump(-1.0), Some(times[1]));
    assert_eq!(at(&input, 5.0, Side::Left), 99.0);
    assert_eq!(at(&input, -5.0, Side::Right), 0.0);
}

#[test]
fn uneven_grids_are_read_alike() {
    let times = [0.0, 0.1, 0.15, 0.4, 1.0];
    let values = [1.0, 2.0, 0.0, 5.0, -1.0];
    let hold = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    assert_eq!(at(&hold, 0.39, Side::Right), 0.0);
    let linear = SampledInput::new(&times, &values, Interpolation::Linear).unwrap();
    assert!((at(&linear, 0.275, Side::Right) - 2.5).abs() < 1e-14);
    assert_eq!(linear.next_jump(0.0), None);
}

/// The ramp passes through each sample in the middle of its hold, and its mean over a hold differs
/// from the held value by an eighth of the second difference.
#[test]
fn a_ramp_follows_the_hold() {
    let times: Vec<f64> = (0..20).map(|k| f64::from(k) * 0.1).collect();
    let values: Vec<f64> = times.iter().map(|t| (2.0 * t).sin()).collect();
    let ramp = SampledInput::new(&times, &values, Interpolation::Ramp).unwrap();
    assert_eq!(at(&ramp, 0.0, Side::Right), values[0]);
    assert_eq!(at(&ramp, -1.0, Side::Right), values[0]);
    assert_eq!(at(&ramp, 9.0, Side::Left), values[19]);
    assert_eq!(ramp.next_jump(0.35), None);
    for k in 1..18 {
        assert!((at(&ramp, times[k] + 0.05, Side::Right) - values[k]).abs() < 1e-14);
        let mean = (0..1000)
            .map(|i| at(&ramp, times[k] + 1e-4 * (f64::from(i) + 0.5), Side::Right))
            .sum::<f64>()
            / 1000.0;
        let second = values[k - 1] - 2.0 * values[k] + values[k + 1];
        assert!((mean - values[k] - second / 8.0).abs() < 1e-6);
    }
    let one = SampledInput::new(&[1.0], &[7.0], Interpolation::Ramp).unwrap();
    assert_eq!(at(&one, 0.0, Side::Right), 7.0);
    // Between samples of an uneven grid it is continuous.
    let uneven = SampledInput::new(&[0.0, 0.1, 0.3], &[1.0, 2.0, 0.0], Interpolation::Ramp);
    let uneven = uneven.unwrap();
    for t in [0.05, 0.1, 0.2, 0.3, 0.4] {
        let (before, after) = (at(&uneven, t - 1e-9, Side::Left), at(&uneven, t, Side::Right));
        assert!((before - after).abs() < 1e-6, "{t}");
    }
}

/// The cubic reproduces a parabola away from the ends and is third-order accurate.
#[test]
fn the_cubic_is_exact_for_parabolas() {
    let times: Vec<f64> = [0.0, 0.13, 0.2, 0.45, 0.5, 0.9, 1.0].to_vec();
    let parabola = |t: f64| 2.0 * t * t - t + 0.3;
    let values: Vec<f64> = times.iter().map(|&t| parabola(t)).collect();
    let input = SampledInput::new(&times, &values, Interpolation::Cubic).unwrap();
    for t in [0.14, 0.33, 0.47, 0.77] {
        assert!((at(&input, t, Side::Right) - parabola(t)).abs() < 1e-14);
    }
}

#[test]
fn bad_samples_are_named() {
    let error = SampledInput::new(&[0.0, 1.0, 1.0], &[0.0; 3], Interpolation::Hold);
    assert!(matches!(error, Err(InputError::NotIncreasing { index: 2, .. })));
    let error = SampledInput::<f64>::new(&[], &[], Interpolation::Linear);
    assert!(matches!(error, Err(InputError::Lengths { .. })));
    let error = SampledInput::new(&[0.0, f64::NAN], &[0.0; 2], Interpolation::Hold);
    assert!(matches!(error, Err(InputError::NotIncreasing { index: 1, .. })));
}

/// `u` is the Jacobian times the samples, and both products are with that Jacobian.
#[test]
fn the_products_are_those_of_the_interpolation() {
    let times = [0.0, 0.13, 0.2, 0.45, 0.5, 0.9, 1.0];
    let values: Vec<f64> = (0..14).map(|k| (f64::from(k) * 1.3).sin()).collect();
    for interpolation in
        [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp, Interpolation::Cubic]
    {
        let input = SampledInput::with_variables(&times, &values, 2, interpolation).unwrap();
        for t in [-1.0, 0.0, 0.05, 0.13, 0.17, 0.46, 0.95, 1.0, 2.0] {
            for side in [Side::Left, Side::Right] {
                let (mut u, mut du) = ([0.0; 2], [0.0; 2]);
                input.value_into(t, side, &mut u);
                input.jvp_into(t, side, &values, &mut du);
                let w = [0.7, -1.1];
                let mut sum = vec![0.0; 14];
                input.vjp_into(t, side, &w, &mut sum);
                let pulled: f64 = sum.iter().zip(&values).map(|(a, b)| a * b).sum();
                let pushed = w[0] * u[0] + w[1] * u[1];
                assert!((u[0] - du[0]).abs() + (u[1] - du[1]).abs() < 1e-14);
                assert!((pulled - pushed).abs() < 1e-14, "{interpolation:?} at {t}");
            }
        }
    }
}
