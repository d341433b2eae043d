//! The rig shows what is published about the joint.

use pam_rig::observables::{Observable, observables};
use pam_rig::plant::PlantParameters;

/// How far an observable may be off, by what it is.
fn tolerance(o: &Observable) -> f64 {
    match o.what.split_whitespace().next().unwrap_or_default() {
        "stiffness" => 0.07 * o.published,
        "equivalent" => 0.06 * o.published,
        "displacement" => 0.2 * o.published,
        "rest" => 0.35,
        "delay" => 8.0,
        "deformation" => 0.4,
        other => panic!("no tolerance is stated for `{other}`"),
    }
}

#[test]
fn published_values_come_out() {
    let all = observables(&PlantParameters::default()).unwrap();
    let count = |unit: &str| all.iter().filter(|o| o.unit == unit).count();
    // Five stiffnesses, three dampings, two displacements and four rest positions, three delays, nu.
    assert_eq!(
        (count("N/mm"), count("kg/s"), count("mm"), count("ms"), count("1")),
        (5, 3, 6, 3, 1)
    );
    let mut off = Vec::new();
    for o in &all {
        if (o.rig - o.published).abs() > tolerance(o) || o.rig.is_nan() {
            off.push(format!("{}: {:.3} instead of {} {}", o.what, o.rig, o.published, o.unit));
        }
    }
    assert!(off.is_empty(), "{}", off.join("\n"));
}
