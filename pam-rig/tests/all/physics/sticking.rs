//! A joint with dry friction stands still, exactly.

use crate::common::{NEWTON_PER_AMPERE, ideal, sealed, sine};
use pam_rig::plant::DryFriction;
use pam_rig::plant::friction::after_friction;
use pam_rig::{Frame, Rig, RigParameters};
use proptest::prelude::*;

fn moved(frames: &[Frame]) -> bool {
    let start = frames[0].truth.displacement_mm.to_bits();
    frames
        .iter()
        .any(|f| f.truth.displacement_mm.to_bits() != start || f.truth.velocity_mm_s.to_bits() != 0)
}

/// The default joint breaks away at 21 N and slides at 18 N.
#[test]
fn a_joint_holds_below_its_threshold_and_moves_above() {
    for side in [1.0, -1.0] {
        let load = |newton: f64| {
            sealed(&ideal(&[]), [45.0, 45.0], 5.0, |_| side * newton / NEWTON_PER_AMPERE)
        };
        let held = load(20.9);
        assert!(!moved(&held));
        for frame in &held {
            assert!((frame.truth.friction_n + side * 20.9).abs() < 1e-9);
        }
        let pushed = load(21.1);
        assert!(moved(&pushed));
        assert!(side * pushed[4999].truth.displacement_mm > 0.0);
    }
}

/// Where the muscles pull unequally the friction carries the difference.
#[test]
fn friction_carries_what_the_tendons_do_not() {
    let mut parameters = ideal(&[]);
    parameters.plant.friction = DryFriction::coulomb(300.0);
    let frames = sealed(&parameters, [30.0, 45.0], 2.0, |_| -0.3);
    assert!(!moved(&frames));
    let truth = frames[1000].truth;
    let [flexor, extensor] = truth.tensions_n;
    // 15 psi on an area of some 808 mm².
    assert!((80.0..90.0).contains(&(extensor - flexor)), "{}", extensor - flexor);
    let sum = truth.force_n + truth.friction_n + flexor - extensor;
    assert!(sum.abs() < 1e-9, "{sum} N");
}

/// After a motion the joint comes to a rest away from its equilibrium and stays there to the last bit,
/// while its air still cools.
#[test]
fn a_joint_that_was_moved_comes_to_rest_for_good() {
    let push = |t: f64| if t < 1.0 { sine(1.5, 1.0)(t) } else { 0.0 };
    let frames = sealed(&RigParameters::default(), [45.0, 45.0], 8.0, push);
    let rest = &frames[3000..];
    assert!(!moved(rest));
    assert!(frames[500].truth.displacement_mm.abs() > 1e-3);
    let temperature = |f: &Frame| f.truth.temperatures_k[0];
    assert_ne!(temperature(&rest[0]), temperature(&rest[4999]));
    assert!(rest[0].truth.displacement_mm.abs() > 1e-3);
}

/// While it slides, friction opposes the velocity with the sliding force; Stribeck's excess of 3 N is
/// gone at five times its velocity of 1 mm/s.
#[test]
fn sliding_friction_opposes_the_motion() {
    let frames = sealed(&ideal(&[]), [45.0, 45.0], 4.0, sine(1.5, 1.0));
    let fast: Vec<_> = frames
        .windows(2)
        .map(|w| [w[0].truth, w[1].truth])
        .filter(|[a, b]| a.velocity_mm_s.abs().min(b.velocity_mm_s.abs()) > 5.0)
        .collect();
    assert!(fast.len() > 500);
    for [row, _] in fast {
        assert!((row.friction_n + 18.0 * row.velocity_mm_s.signum()).abs() < 1e-6);
    }
    assert!(frames.iter().all(|f| f.truth.friction_n.abs() < 21.0 + 1e-9));
}

/// A joint that slides more hardly than it breaks away would neither rest nor move.
#[test]
fn friction_that_is_lower_at_rest_is_refused() {
    let mut parameters = ideal(&[]);
    parameters.plant.friction = DryFriction { coulomb_n: 20.0, static_n: 10.0, velocity_mm_s: 1.0 };
    let message = |p: &RigParameters| Rig::new(p, 1, 0.0).err().unwrap().to_string();
    assert!(message(&parameters).contains("plant.friction.static_n"));
    let effect = ideal(&["stribeck_friction:coulomb_n=20,static_n=10,velocity_mm_s=1"]);
    assert!(message(&effect).contains("static_n"));
}

proptest! {
    /// Friction takes speed and never gives any: what is left points where the joint went or where
    /// it is pushed, and is not faster than without friction.
    #[test]
    fn friction_never_drives(
        before in -5.0..5.0_f64,
        change in -5.0..5.0_f64,
        sliding in 0.0..3.0_f64,
        excess in 0.0..3.0_f64,
    ) {
        let after = after_friction(before, change, sliding, sliding + excess);
        prop_assert!(after * before >= 0.0 || after * change >= 0.0);
        prop_assert!(after.abs() <= before.abs().max((before + change).abs()));
        if before == 0.0 || before * (before + change) < 0.0 {
            prop_assert!(after == 0.0 || after * change > 0.0);
        }
        prop_assert_eq!(-after_friction(-before, -change, sliding, sliding + excess), after);
    }
}
