//! Effects in the mechanics. What a force does is read off Newton's second law and the truth.

use crate::common::{
    MASS_KG, NEWTON_PER_AMPERE, Unknown, ideal, largest, line, logged_mm, plain, sealed, sine,
    unknown_force,
};
use pam_rig::plant::DryFriction;
use pam_rig::{Frame, RigParameters};
use std::f64::consts::E;

const PSI: [f64; 2] = [45.0, 45.0];

/// The unknown force of a springs-and-mass joint with an effect.
fn force_of(effect: &str, seconds: f64, current: impl Fn(f64) -> f64) -> Vec<Unknown> {
    unknown_force(&sealed(&plain(&[effect]), PSI, seconds, current), MASS_KG)
}

/// A damped joint, and where it rests in the end.
fn rest_mm(effect: &str, newton: f64) -> f64 {
    let mut parameters = plain(&[effect]);
    parameters.plant.viscous_ns_m = 1e4;
    let frames = sealed(&parameters, PSI, 4.0, |_| newton / NEWTON_PER_AMPERE);
    let last = &frames[frames.len() - 1].truth;
    assert!(last.velocity_mm_s.abs() < 1e-6);
    last.displacement_mm
}

fn holds(frames: &[Frame]) -> bool {
    frames.iter().all(|f| f.truth.displacement_mm == 0.0 && f.truth.velocity_mm_s == 0.0)
}

/// Without the joint's own friction 25 N hold and slide at 25 N; with it they add to its 21 N.
#[test]
fn coulomb_friction() {
    let effect = "coulomb_friction:force_n=25";
    let held = |p: &RigParameters, newton: f64| {
        holds(&sealed(p, PSI, 1.0, |_| newton / NEWTON_PER_AMPERE))
    };
    assert!(held(&plain(&[effect]), 24.9) && !held(&plain(&[effect]), 25.1));
    assert!(held(&ideal(&[effect]), 45.9) && !held(&ideal(&[effect]), 46.1));
    let frames = sealed(&plain(&[effect]), PSI, 4.0, sine(1.5, 1.0));
    let slides =
        frames.windows(2).filter(|w| w[0].truth.velocity_mm_s * w[1].truth.velocity_mm_s > 1.0);
    let mut count = 0;
    for pair in slides {
        let truth = pair[0].truth;
        assert!((truth.friction_n + 25.0 * truth.velocity_mm_s.signum()).abs() < 1e-6);
        count += 1;
    }
    assert!(count > 1000);
}

/// 30 N at rest, 12 N far above 1.5 mm/s, the difference divided by e at 1.5 mm/s.
#[test]
fn stribeck_friction() {
    let effect = "stribeck_friction:coulomb_n=12,static_n=30,velocity_mm_s=1.5";
    let held =
        |newton: f64| holds(&sealed(&plain(&[effect]), PSI, 1.0, |_| newton / NEWTON_PER_AMPERE));
    assert!(held(29.9) && held(-29.9) && !held(30.1) && !held(-30.1));
    let frames = sealed(&plain(&[effect]), PSI, 8.0, sine(1.0, 0.5));
    // Friction of a sample belongs to the middle between its velocity and the next one.
    let points = |low: f64, high: f64| -> Vec<f64> {
        frames
            .windows(2)
            .map(|w| (0.5 * (w[0].truth.velocity_mm_s + w[1].truth.velocity_mm_s), w[0].truth))
            .filter(|(v, _)| (low..high).contains(&v.abs()))
            .map(|(v, truth)| -truth.friction_n * v.signum())
            .collect()
    };
    let near = |low: f64, high: f64, expected: f64, tolerance: f64| {
        let all = points(low, high);
        assert!(all.len() > 10, "{} points between {low} and {high} mm/s", all.len());
        let worst = largest(all.iter().map(|f| (f - expected).abs()));
        assert!(worst < tolerance, "{worst} N off {expected} N");
    };
    near(1.48, 1.52, 12.0 + 18.0 / E, 0.3);
    near(2.98, 3.02, 12.0 + 18.0 / E.powi(4), 0.1);
    near(6.0, 50.0, 12.0, 1e-3);
}

/// 0.1 N/kPa times the mean gauge pressure of 45 psi (310.3 kPa), or of 30 and 60 psi, hold 31 N; of 20 psi 13.8 N. It adds to
/// other friction, and follows the pressures while it slides.
#[test]
fn load_friction() {
    let effect = "load_friction:force_n_per_kpa=0.1";
    let coulomb = "coulomb_friction:force_n=5";
    let held = |effects: &[&str], psi: [f64; 2], newton: f64| {
        // Held against springs that balance at x = 0: equal pressures.
        holds(&sealed(&plain(effects), psi, 0.5, |_| newton / NEWTON_PER_AMPERE))
    };
    for (psi, limit) in [(45.0, 31.026), (20.0, 13.790)] {
        assert!(
            held(&[effect], [psi; 2], limit - 0.05) && !held(&[effect], [psi; 2], limit + 0.05)
        );
        let both = [effect, coulomb];
        assert!(held(&both, [psi; 2], limit + 4.95) && !held(&both, [psi; 2], limit + 5.05));
    }
    let frames = sealed(&plain(&[effect]), PSI, 4.0, sine(1.5, 1.0));
    let slides =
        frames.windows(2).filter(|w| w[0].truth.velocity_mm_s * w[1].truth.velocity_mm_s > 1.0);
    let mut count = 0;
    for pair in slides {
        let truth = pair[0].truth;
        let [flexor, extensor] = truth.pressures_kpa;
        let expected = 0.1 * (0.5 * (flexor + extensor) - 101.325) * truth.velocity_mm_s.signum();
        // Friction of a sample is a mean to the next one.
        assert!((truth.friction_n + expected).abs() < 1e-2, "{} {expected}", truth.friction_n);
        count += 1;
    }
    assert!(count > 1000);
}

#[test]
fn viscous_damping() {
    let points: Vec<_> = force_of("viscous_damping:coefficient_ns_m=3000", 3.0, sine(1.0, 1.0))
        .iter()
        .map(|u| (u.velocity_mm_s, u.force_n))
        .collect();
    let (slope, intercept) = line(&points);
    // 3000 N·s/m are 3 N at 1 mm/s, against the motion.
    assert!((slope + 3.0).abs() < 0.02 && intercept.abs() < 0.02, "{slope} {intercept}");
}

/// Elements whose slip distances are spread evenly up to s = 0.6 mm carry `F w (1 − ln w)` with `w = u/s` after a travel `u`
/// from rest, and lose twice that with `w = u/2s` after a turn (Masing 1926); the rate does not matter.
#[test]
fn hysteresis() {
    for frequency_hz in [0.25, 1.0] {
        let mut parameters = plain(&["hysteresis:force_n=20,slip_mm=0.6"]);
        parameters.plant.viscous_ns_m = 2e4;
        let frames = sealed(&parameters, PSI, 2.0 / frequency_hz, sine(2.0, frequency_hz));
        let known = |u: &Unknown| u.force_n + 20.0 * u.velocity_mm_s;
        let made = unknown_force(&frames, MASS_KG);
        let turns: Vec<usize> = (1..made.len())
            .filter(|&k| made[k - 1].velocity_mm_s * made[k].velocity_mm_s < 0.0)
            .collect();
        assert!(turns.len() >= 3, "{turns:?}");
        // From rest to the first turn, then from turn to turn.
        for (i, u) in made.iter().enumerate().take(turns[2]).skip(3) {
            let started = turns.iter().rev().find(|t| **t <= i).copied();
            let travel = u.displacement_mm - started.map_or(0.0, |t| made[t].displacement_mm);
            let long = if started.is_some() { 1.2 } else { 0.6 };
            let force = known(u) * u.velocity_mm_s.signum();
            if travel.abs() > long + 0.01 {
                assert!((force + 20.0).abs() < 0.1, "{force} N after {travel} mm");
            } else if (1e-3..long - 0.05).contains(&travel.abs()) {
                let way = travel.abs() / long;
                let curve = 20.0 * way * (1.0 - way.ln());
                let expected = if started.is_some() { 20.0 - 2.0 * curve } else { -curve };
                assert!(
                    (force - expected).abs() < 0.3,
                    "{force} N, not {expected}, after {travel} mm"
                );
            }
            if started.is_some() && travel.abs() < 1e-2 {
                assert!(force > 18.0, "the turn is forgotten: {force} N");
            }
        }
        let widest = largest(made[..turns[0]].iter().map(|u| u.displacement_mm));
        assert!(widest > 0.7, "{widest} mm");
    }
}

/// Stuck after a push, the spring of 20 N/mm relaxes through its damper with 0.8 s.
#[test]
fn creep() {
    let mut parameters = plain(&["creep:stiffness_n_mm=20,time_constant_s=0.8"]);
    parameters.plant.friction = DryFriction::coulomb(120.0);
    let frames = sealed(&parameters, PSI, 3.0, |_| 1.5);
    let made = unknown_force(&frames, MASS_KG);
    let stuck = made.iter().rposition(|u| u.velocity_mm_s != 0.0).unwrap() + 3;
    let rest = &made[stuck..];
    assert!(rest.len() > 2000 && rest[0].displacement_mm > 0.4, "{rest:?}");
    assert!(rest[0].force_n < -5.0, "{} N", rest[0].force_n);
    let logs: Vec<_> = rest.iter().map(|u| (u.time_s, (-u.force_n).ln())).collect();
    let (slope, _) = line(&logs);
    assert!((slope + 1.0 / 0.8).abs() < 1e-3, "{slope} 1/s");
    // In 50 ms little has relaxed: the spring pushes back with its stiffness.
    let fast = made.iter().find(|u| u.displacement_mm > 0.2).unwrap();
    let stiffness = -fast.force_n / fast.displacement_mm;
    assert!((stiffness / 20.0 - 1.0).abs() < 0.06, "{stiffness} N/mm");
}

/// 20 N of load do what 20 N of the motor do, in the direction of +x.
#[test]
fn constant_load() {
    let rest = rest_mm("constant_load:force_n=20", 0.0);
    assert!(rest > 0.05 && (rest - rest_mm("constant_load:force_n=0", 20.0)).abs() < 1e-9);
    assert!((rest_mm("constant_load:force_n=-20", 20.0)).abs() < 1e-9);
    let made = force_of("constant_load:force_n=20", 2.0, sine(1.0, 1.0));
    assert!(made.iter().skip(1).all(|u| (u.force_n - 20.0).abs() < 0.1));
}

/// Periods grow with the root of the mass.
#[test]
fn added_inertia() {
    let period_s = |effect: &str| {
        let kick = |t: f64| if t < 0.05 { 0.2 } else { 0.0 };
        let frames = sealed(&plain(&[effect]), PSI, 10.0, kick);
        let v = |k: usize| frames[k].truth.velocity_mm_s;
        let crossings: Vec<f64> = (100..frames.len() - 1)
            .filter(|&k| v(k) < 0.0 && v(k + 1) >= 0.0)
            .map(|k| 1e-3 * (k as f64 + v(k) / (v(k) - v(k + 1))))
            .collect();
        (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64
    };
    let ratio = period_s("added_inertia:mass_kg=60") / period_s("added_inertia:mass_kg=0");
    assert!((ratio - (375.0_f64 / 315.0).sqrt()).abs() < 1e-4, "{ratio}");
}

/// The encoder follows 0.15 mm behind on either side: a play of 0.3 mm in all.
#[test]
fn backlash() {
    let mut parameters = plain(&["backlash:gap_mm=0.3"]);
    parameters.plant.viscous_ns_m = 2e4;
    let frames = sealed(&parameters, PSI, 4.0, sine(1.5, 1.0));
    let behind = |f: &Frame| f.truth.displacement_mm - logged_mm(f);
    assert!((largest(frames.iter().map(behind)) - 0.15).abs() < 1e-12);
    assert!((largest(frames.iter().map(|f| -behind(f))) - 0.15).abs() < 1e-12);
    // The joint travels 0.3 mm before the encoder sees that it turned.
    let mut turned: Option<f64> = None;
    let mut seen = 0;
    for pair in frames[1000..].windows(2) {
        let [before, now] = [&pair[0].truth, &pair[1].truth];
        if before.velocity_mm_s * now.velocity_mm_s < 0.0 {
            // The encoder may still have been pushed a little way before the turn.
            turned = Some(now.displacement_mm);
            continue;
        }
        let Some(from) = turned else { continue };
        let travel = (now.displacement_mm - from).abs();
        let moves = logged_mm(&pair[0]) != logged_mm(&pair[1]);
        assert!(!(moves && travel < 0.299), "the encoder moved after {travel} mm");
        assert!(moves || travel < 0.301);
        seen += usize::from(moves);
    }
    assert!(seen > 1000);
}

/// −10 N sin(2π x / 0.6 mm).
#[test]
fn cogging() {
    let made = force_of("cogging:force_n=10,pitch_mm=0.6", 6.0, sine(1.2, 0.5));
    let mean = |x: f64| {
        let near = made[1..].iter().filter(|u| (u.displacement_mm - x).abs() < 0.005);
        let (sum, count) = near.fold((0.0, 0), |s, u| (s.0 + u.force_n, s.1 + 1));
        assert!(count > 5, "{count} points near {x} mm");
        sum / f64::from(count)
    };
    for pitches in [-1.0, 0.0, 1.0] {
        for (place, expected) in [(0.0, 0.0), (0.25, -10.0), (0.5, 0.0), (-0.25, 10.0)] {
            let force = mean(0.6 * (pitches + place));
            assert!((force - expected).abs() < 0.3, "{force} N at {pitches} + {place} pitches");
        }
    }
}

/// Beyond 0.6 mm the volume of the shortening chamber stays constant, and the restoring force grows by 40 % less than without the
/// effect. The reduction includes the part due to the higher pressure.
#[test]
fn tendon_slack() {
    let psi = [40.0, 50.0];
    let free = unknown_force(&sealed(&plain(&[]), psi, 4.0, sine(2.4, 0.5)), MASS_KG);
    let restoring_n = |at_mm: f64| {
        let near = free[2..].iter().filter(|u| (u.displacement_mm - at_mm).abs() < 0.02);
        let near: Vec<_> = near.map(|u| (u.displacement_mm, -u.muscles_n)).collect();
        assert!(near.len() > 5, "{} points near {at_mm} mm", near.len());
        let (slope, intercept) = line(&near);
        slope * at_mm + intercept
    };
    let effect = "tendon_slack:displacement_mm=0.6,stiffness_loss=0.4";
    let frames = sealed(&plain(&[effect]), psi, 4.0, sine(1.0, 0.5));
    let x = |f: &Frame| f.truth.displacement_mm;
    let made = unknown_force(&frames, MASS_KG);
    for (i, side) in [(0, 1.0), (1, -1.0)] {
        let volume = |f: &Frame| f.truth.volumes_mm3[i];
        let slack: Vec<_> = frames.iter().filter(|f| side * x(f) > 0.6).collect();
        assert!(slack.len() > 300, "{}", slack.len());
        assert!(slack.iter().all(|f| volume(f) == volume(slack[0])));
        let taut: Vec<_> = frames.iter().filter(|f| side * x(f) < 0.59).collect();
        assert!(taut.iter().all(|f| volume(f) < volume(slack[0])));
        let edge_n = restoring_n(side * 0.6);
        let mut most = 0.0_f64;
        for u in made[2..].iter().filter(|u| side * u.displacement_mm > 0.0) {
            let whole_n = restoring_n(u.displacement_mm);
            let lost_n =
                if side * u.displacement_mm > 0.6 { 0.4 * (whole_n - edge_n) } else { 0.0 };
            let off = -u.muscles_n - u.force_n - (whole_n - lost_n);
            assert!(off.abs() < 0.25, "{off} N at {} mm", u.displacement_mm);
            most = most.max(side * lost_n);
        }
        assert!(most > 15.0, "{most} N");
    }
}

/// Tendons that balance 100 N at first balance 100 N / 1.5 after half a minute at 1 per minute, and
/// nothing grows before time zero.
#[test]
fn stiffness_drift() {
    let mut parameters = plain(&["stiffness_drift:relative_per_min=1"]);
    parameters.plant.viscous_ns_m = 1e4;
    let frames = sealed(&parameters, PSI, 31.0, |_| 100.0 / NEWTON_PER_AMPERE);
    for second in [5, 15, 30] {
        let [flexor, extensor] = frames[1000 * second].truth.tensions_n;
        let expected = 100.0 / (1.0 + second as f64 / 60.0);
        let made = extensor - flexor;
        assert!((made / expected - 1.0).abs() < 2e-3, "{made} of {expected} N at {second} s");
    }
}

/// A stiffness that is off by r deflects 1/(1 + r) as far.
#[test]
fn stiffness_scale() {
    let soft = rest_mm("stiffness_scale:relative=0", 2.0);
    for relative in [0.25, -0.2] {
        let made = rest_mm(&format!("stiffness_scale:relative={relative}"), 2.0);
        let ratio = made / soft * (1.0 + relative);
        assert!((ratio - 1.0).abs() < 2e-3, "{relative}: {made} of {soft} mm");
    }
}
