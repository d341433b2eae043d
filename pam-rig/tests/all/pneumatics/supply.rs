use pam_rig::pneumatics::{Supply, SupplyParameters};

#[test]
fn what_is_taken_is_made_up_for() {
    let mut supply = Supply::new(SupplyParameters::default());
    let full = supply.pressure_kpa();
    supply.give(0.05, 0.0);
    // 0.05 g in 400 cm³ are 0.05 · 8.47e7 / 4e5 = 10.6 kPa.
    assert!((full - supply.pressure_kpa() - 10.5875).abs() < 1e-9);
    supply.give(0.0, 5.0);
    assert!(full - supply.pressure_kpa() < 1e-3);
}
