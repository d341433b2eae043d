use pam_baselines::koopman::Dictionary;

#[test]
fn every_place_is_written_and_counted() {
    for d in Dictionary::ALL {
        let mut out = vec![f64::NAN; d.len() + 1];
        d.lift(&[2.0, 3.0, 5.0, 7.0], &mut out);
        assert!(out[..d.len()].iter().all(|v| v.is_finite()), "{d:?}");
        assert!(out[d.len()].is_nan());
        assert_eq!(Dictionary::of_len(d.len()), Some(d));
    }
    let mut out = vec![0.0; 35];
    Dictionary::ThirdOrder.lift(&[2.0, 3.0, 5.0, 7.0], &mut out);
    // Products of primes are all different: no term twice.
    let mut sorted = out.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    assert_eq!(sorted.len(), 35);
}
