use super::testing::{assert_cotangents, noisy, random_recording};
use pam_data::Recording;
use pam_trajectory::loss::{Huber, HuberForm, Masked, Normalised};
use pam_trajectory::{SquaredError, TrajectoryLoss};
use proptest::prelude::*;

fn masked<L>(of: L, every: usize, intervals_s: &[[f64; 2]]) -> Masked<L> {
    Masked { of: Box::new(of), every, intervals_s: intervals_s.to_vec() }
}

fn evaluate(loss: &dyn TrajectoryLoss, m: &Recording, p: &[[f64; 4]]) -> (f64, Vec<[f64; 4]>) {
    // What was there before must not matter.
    let mut cotangents = vec![[f64::NAN; 4]; p.len()];
    (loss.value_and_cotangents(m, p, &mut cotangents), cotangents)
}

#[test]
fn cotangents_are_the_derivative() {
    let thresholds = [1.0; 4];
    let huber = Huber { form: HuberForm::PseudoHuber, thresholds, weights: [1.0; 4] };
    for seed in 0..5 {
        assert_cotangents(&masked(SquaredError::published(), 3, &[]), seed);
        assert_cotangents(&masked(Normalised::default(), 2, &[[0.02, 0.2]]), seed);
        assert_cotangents(&masked(huber, 1, &[[0.0, 0.05], [0.1, 0.13]]), seed);
    }
}

/// Samples lie 0.01 s apart from 7.3 s on.
#[test]
fn time_is_that_since_the_first_sample() {
    let time_s: Vec<f64> = (0..30).map(|k| 7.3 + 0.01 * f64::from(k)).collect();
    let samples = |every, intervals: &[[f64; 2]]| masked((), every, intervals).samples(&time_s);
    assert_eq!(samples(10, &[]), [0, 10, 20]);
    assert_eq!(samples(1, &[[0.05, 0.08]]), [5, 6, 7, 8]);
    assert_eq!(samples(2, &[[0.05, 0.08], [0.07, 0.11]]), [6, 8, 10]);
    assert_eq!(samples(1, &[[7.3, 7.5]]), Vec::<usize>::new());
}

#[test]
fn a_loss_of_no_sample_is_zero() {
    let measured = random_recording(10, 1);
    let loss = masked(SquaredError::paper(), 1, &[[50.0, 60.0]]);
    let (value, cotangents) = evaluate(&loss, &measured, &noisy(&measured, 2));
    assert_eq!((value, cotangents), (0.0, vec![[0.0; 4]; 10]));
}

proptest! {
    #[test]
    fn samples_outside_do_not_matter(
        n in 2_usize..60,
        every in 1_usize..7,
        from in 0.0_f64..0.5,
        width in 0.0_f64..0.3,
        seed in 0_u64..1000,
    ) {
        let measured = random_recording(n, seed);
        let predicted = noisy(&measured, seed + 1);
        let loss = masked(SquaredError::paper(), every, &[[from, from + width]]);
        let counts = loss.samples(&measured.time_s);
        let (value, cotangents) = evaluate(&loss, &measured, &predicted);
        let mut other = predicted.clone();
        for k in 0..n {
            if counts.contains(&k) {
                prop_assert!(k % every == 0);
            } else {
                prop_assert_eq!(cotangents[k], [0.0; 4]);
                other[k] = [1e9; 4];
            }
        }
        prop_assert_eq!(evaluate(&loss, &measured, &other), (value, cotangents));
    }

    /// The mean over all samples is that of the n interleaved masks, each by its share.
    #[test]
    fn disjoint_masks_add_up(n in 2_usize..60, cut in 0.0_f64..0.6, seed in 0_u64..1000) {
        let measured = random_recording(n, seed);
        let predicted = noisy(&measured, seed + 1);
        let whole = evaluate(&SquaredError::paper(), &measured, &predicted).0;
        // Not at a sample, of which both closed intervals would take hold.
        let cut = (cut / 0.01).floor() * 0.01 + 0.005;
        let sum: f64 = [[0.0, cut], [cut, 1e3]]
            .iter()
            .map(|interval| {
                let loss = masked(SquaredError::paper(), 1, &[*interval]);
                let share = loss.samples(&measured.time_s).len() as f64 / n as f64;
                share * evaluate(&loss, &measured, &predicted).0
            })
            .sum();
        prop_assert!((sum - whole).abs() <= 1e-12 * whole);
    }
}
