use pam_rig::Protocol;

#[test]
fn every_built_in_protocol_is_sound() {
    for name in Protocol::BUILT_IN {
        let protocol = Protocol::built_in(name).unwrap();
        assert_eq!(protocol.name, name);
        assert!(!protocol.runs().unwrap().is_empty());
    }
}

/// Section VI of the source: 0.5 Hz for 0–40 s, 1 Hz for 40–60 s, 2 Hz for 60–70 s, each at 1 A
/// and at 1.5 A.
#[test]
fn the_paper_excitation_is_the_published_one() {
    let paper = Protocol::paper();
    assert_eq!(paper.duration_s(), 70.0);
    assert_eq!(paper.runs().unwrap().len(), 29);
    for (peak_s, current) in
        [(0.5, 1.0), (20.5, 1.5), (40.25, 1.0), (50.25, 1.5), (60.125, 1.0), (65.125, 1.5)]
    {
        assert!((paper.current_a(peak_s, 0) - current).abs() < 1e-9, "{peak_s}");
    }
    assert_eq!(paper.current_a(-1.0, 0), 0.0);
    assert_eq!(paper.current_a(70.0, 0), 0.0);
}
