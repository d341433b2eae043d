//! Limits of detection of the study.

use pam_tests::plant::Hidden;
use pam_tests::study::data::sized;
use pam_tests::study::nuisances::{Basis, norm};
use pam_tests::study::{Case, Factors, design};

/// One nuisance parameter: the size by the inverse of `1 + d dᵀ` (Sherman and Morrison 1950).
#[test]
fn a_nuisance_parameter_explains_what_its_tolerance_allows() {
    let (r, d) = (vec![3.0, 1.0, -2.0], vec![0.5, 2.0, 1.0]);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let expected = dot(&r, &r) - dot(&r, &d).powi(2) / (1.0 + dot(&d, &d));
    let left = norm(&Basis::of_nuisances(vec![d]).orthogonal(r)).powi(2);
    assert!((left - expected).abs() < 1e-12, "{left} and {expected}");
}

/// A direction with a free amplitude is removed completely.
#[test]
fn nothing_is_left_of_a_free_direction() {
    let mut basis = Basis::of_nuisances(vec![vec![0.5, 2.0, 1.0], vec![1.0, 0.0, 1.0]]);
    basis.add(vec![3.0, 1.0, -2.0]);
    assert!(norm(&basis.orthogonal(vec![-6.0, -2.0, 4.0])) < 1e-12);
    assert!(norm(&basis.orthogonal(vec![1.0, 0.0, 0.0])) > 0.1);
}

/// A pressure bias of a quarter of a percent cannot be told from the tolerance of the sealed mass in one recording, one of forty times as much
/// can; a delay of a quarter of a sample is within the tolerance of the time of the force, and one of ten samples is not.
#[test]
fn what_is_within_tolerances_is_below_the_limit() {
    let any = design::of_seed(13).into_iter().next().expect("a case");
    let factors = Factors { recordings: 1, rate_hz: 100.0, ..Factors::default() };
    let case = Case { factors, conditions: vec![[45.0, 45.0]], ..any };
    let limits = |id: &str, name: &str, value: f64| {
        let sizes = sized(&case, &[Hidden::new(id, &[(name, value)])]);
        sizes[0].limits.expect("a measured size")
    };
    for (id, name, within) in
        [("pressure_bias", "flexor_kpa", 1.0), ("actuation_delay", "delay_ms", 2.5)]
    {
        let (small, large) = (limits(id, name, within), limits(id, name, 40.0 * within));
        assert!(small < 1.0, "{id}: {small} limits");
        assert!(large > 2.0, "{id}: {large} limits");
    }
}
