use pam_ablate::statistics::{Paired, holm};

/// The extra hours of sleep of Student (1908), drug 2 less drug 1: t = 4.0621, p = 0.00283; and the
/// signed-rank test of the nine that differ: all are positive, p = 2/2⁹.
#[test]
fn students_sleep_data() {
    let d = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
    let found = Paired::of(&d).unwrap();
    assert!((found.mean - 1.58).abs() < 1e-12);
    assert!((found.t.unwrap() - 4.0621).abs() < 1e-4);
    assert!((found.p_t.unwrap() - 0.002_833).abs() < 1e-6);
    let [low, high] = found.interval.unwrap();
    assert!((low - 0.700_114).abs() < 1e-5 && (high - 2.459_886).abs() < 1e-5, "{low} {high}");
    assert_eq!(found.w, 45.0);
    assert!((found.p_wilcoxon.unwrap() - 2.0 / 512.0).abs() < 1e-15);
}

/// By hand: |d| = 1, 2, 3, 4 with the 2 negative: W = 1 + 3 + 4 = 8, and of the 16 sums of ranks those
/// of 0, 1 and 2 are at most 10 − 8: p = 2 · 3/16.
#[test]
fn signed_ranks_by_hand_and_with_ties() {
    let found = Paired::of(&[1.0, -2.0, 3.0, 4.0]).unwrap();
    assert_eq!((found.w, found.p_wilcoxon), (8.0, Some(0.375)));
    // Ranks 1.5, 1.5, 3: sums 0, 1.5 (twice), 3 (twice), 4.5 (twice), 6.
    let found = Paired::of(&[1.0, 1.0, 2.0]).unwrap();
    assert_eq!((found.w, found.p_wilcoxon), (6.0, Some(0.25)));
    assert_eq!(Paired::of(&[0.0, 0.0]).unwrap().p_wilcoxon, None);
    assert_eq!(Paired::of(&[0.5]).unwrap().interval, None);
    assert!(Paired::of(&[]).is_none());
}

#[test]
fn the_normal_approximation_meets_the_exact_count() {
    let d: Vec<f64> =
        (1..=60).map(|i| if i % 3 == 0 { -f64::from(i) } else { f64::from(i) }).collect();
    let exact = Paired::of(&d).unwrap().p_wilcoxon.unwrap();
    let mut more = d.clone();
    more.push(1e-3);
    let normal = Paired::of(&more).unwrap().p_wilcoxon.unwrap();
    assert!((exact / normal - 1.0).abs() < 0.1, "{exact} {normal}");
}

#[test]
fn holm_by_hand() {
    let corrected = holm(&[Some(0.04), None, Some(0.01), Some(0.03)]);
    assert_eq!(corrected, [Some(0.06), None, Some(0.03), Some(0.06)]);
}
