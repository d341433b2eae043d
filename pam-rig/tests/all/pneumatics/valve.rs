use approx::assert_relative_eq;
use pam_rig::pneumatics::{AirState, Opening, Valve, ValveParameters, iso_6358_flow_g_s};

/// The definition of C: at the reference temperature a choked orifice passes C dm³/s of
/// reference air for every bar upstream.
#[test]
fn choked_flow_is_conductance_times_pressure() {
    let flow = iso_6358_flow_g_s(0.1, 0.3, 600.0, 293.15, 150.0);
    assert_relative_eq!(flow, 0.1 * 1.185 * 6.0, max_relative = 1e-12);
}

#[test]
fn subsonic_flow_falls_on_an_ellipse_to_zero() {
    let choked = iso_6358_flow_g_s(0.1, 0.3, 600.0, 293.15, 180.0);
    let half = iso_6358_flow_g_s(0.1, 0.3, 600.0, 293.15, 600.0 * 0.65);
    assert_relative_eq!(half / choked, (1.0_f64 - 0.25).sqrt(), max_relative = 1e-12);
    assert_eq!(iso_6358_flow_g_s(0.1, 0.3, 600.0, 293.15, 600.0), 0.0);
    let (below, above) = (
        iso_6358_flow_g_s(0.1, 0.3, 600.0, 300.0, 599.399),
        iso_6358_flow_g_s(0.1, 0.3, 600.0, 300.0, 599.401),
    );
    assert_relative_eq!(below, above, max_relative = 1e-2);
}

#[test]
fn valves_follow_their_command_late() {
    let mut valve = Valve::new(ValveParameters { response_ms: 2.0, ..Default::default() }, 1e-3);
    let air = |pressure_kpa| AirState { pressure_kpa, temperature_k: 295.0 };
    let flows: Vec<f64> = [Opening::Inflate, Opening::Shut, Opening::Shut, Opening::Shut]
        .map(|c| valve.flow(c, air(700.0), air(200.0), 101.0).into_muscle_g_s)
        .to_vec();
    assert_eq!(flows[..2], [0.0, 0.0]);
    assert!(flows[2] > 0.0 && flows[3] == 0.0);
}
