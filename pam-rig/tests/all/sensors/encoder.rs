use pam_rig::sensors::EncoderParameters;

#[test]
fn the_step_is_the_published_one() {
    let encoder = EncoderParameters::default();
    assert!((encoder.step_deg - 0.087_890_6).abs() < 1e-7);
    assert!((encoder.read_deg(-0.010_55 * 10.0) - 0.878_906).abs() < 1e-6);
}
