use pam_train::{Segment, frequency_segments};
use std::f64::consts::TAU;

/// The published protocol: 0.5 Hz to 40 s, 1 Hz to 60 s, 2 Hz to 70 s, two amplitudes each.
#[test]
fn the_published_protocol_has_three_segments() {
    let time: Vec<f64> = (0..70_000).map(|k| f64::from(k) * 1e-3).collect();
    let mut noise = 1_u32;
    let force: Vec<f64> = time
        .iter()
        .map(|&t| {
            let f = if t < 40.0 {
                0.5
            } else if t < 60.0 {
                1.0
            } else {
                2.0
            };
            let amplitude = if ((t / 10.0) as u32).is_multiple_of(2) { 133.5 } else { 200.0 };
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            amplitude * (TAU * f * t).sin() + 20.0 * (f64::from(noise) / 4.3e9 - 0.5)
        })
        .collect();
    let segments = frequency_segments(&time, &force);
    let labels: Vec<String> = segments.iter().map(Segment::label).collect();
    assert_eq!(labels, ["0.5 Hz", "1 Hz", "2 Hz"]);
    for (s, end) in segments.iter().zip([40.0, 60.0, 70.0]) {
        assert!((time[s.range.end - 1] - end).abs() < 2.5, "{s:?}");
    }
    assert_eq!(segments[0].range.start, 0);
    assert_eq!(segments[2].range.end, time.len());
}

#[test]
fn a_force_without_cycles_is_one_segment() {
    let time: Vec<f64> = (0..100).map(f64::from).collect();
    let segments = frequency_segments(&time, &vec![1.0; 100]);
    assert_eq!(segments, [Segment { range: 0..100, frequency_hz: None, cycles: 0 }]);
    let ramp: Vec<f64> = time.clone();
    assert_eq!(frequency_segments(&time, &ramp)[0].frequency_hz, None);
}
