use pam_baselines::comparison::Summary;

#[test]
fn stopped_predictions_count_as_worst_in_the_median_only() {
    let s = Summary::of(&[Some(0.9), None, Some(0.5), Some(0.7), None]);
    assert!((s.mean.unwrap() - 0.7).abs() < 1e-15);
    assert!((s.deviation.unwrap() - 0.2).abs() < 1e-15);
    assert_eq!((s.median, s.count, s.stopped), (Some(0.5), 5, 2));
    assert_eq!(Summary::of(&[None, Some(1.0)]).median, None);
    assert_eq!(Summary::of(&[Some(2.0), Some(1.0)]).median, Some(1.5));
    assert_eq!(Summary::of(&[]).mean, None);
}
