use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N};
use pam_core::{JointModel, SealedMasses, SpringDamper};

use pam_report::force_curves::{VELOCITIES_MM_S, equilibria_mm, force_curve, force_curves};
use pam_report::page::number;

/// A spring whose equilibrium is known: `shift (m_f − m_e) − B ẋ / K`.
fn model(shift: f64) -> JointModel<f64, SpringDamper<f64>> {
    let mut force = SpringDamper::published();
    force.shift_per_mass_mm_g = shift;
    JointModel::datasheet(force)
}

fn known_zero(model: &JointModel<f64, SpringDamper<f64>>, m: SealedMasses, v: f64) -> f64 {
    let f = &model.force;
    let k = f.stiffness_mn_mm + f.stiffness_per_mass_mn_mm_g * (m.flexor_g + m.extensor_g);
    f.shift_per_mass_mm_g * (m.flexor_g - m.extensor_g) - f.damping_kg_s * v / k
}

#[test]
fn equilibria_are_where_the_formula_says_and_where_the_curve_crosses() {
    let model = model(-20.0);
    let masses = model.gas_law_masses(0.0, [300.0, 520.0]);
    for v in VELOCITIES_MM_S {
        let zeros = equilibria_mm(&model, masses, v);
        assert_eq!(zeros.len(), 1);
        assert!((zeros[0] - known_zero(&model, masses, v)).abs() < 1e-9);
        let curve = force_curve(&model, masses, v);
        let (below, above) = curve.split_at(curve.partition_point(|p| p.0 < zeros[0]));
        assert!(below.iter().all(|p| p.1 < 0.0) && above.iter().all(|p| p.1 >= 0.0));
    }
}

#[test]
fn an_equilibrium_on_a_grid_point_is_found_once_and_one_outside_not_at_all() {
    let masses = SealedMasses::new(0.05, 0.05).unwrap();
    assert_eq!(equilibria_mm(&model(0.0), masses, 0.0), [0.0]);
    let unequal = SealedMasses::new(0.12, 0.03).unwrap();
    assert!(equilibria_mm(&model(-100.0), unequal, 0.0).is_empty());
}

#[test]
fn the_section_draws_every_pair_and_lists_the_stiffness() {
    let html = force_curves(&model(-20.0)).into_string();
    for part in ["170/170", "653/653", "308/515", "653/170", "−5 mm/s", "+5 mm/s"] {
        assert!(html.contains(part), "{part}");
    }
    // Marks at zero force at standstill: five a panel.
    assert_eq!(html.matches("<circle").count(), 10);
    let model = model(-20.0);
    let m = model.gas_law_masses(0.0, [10.0 * KPA_PER_PSI + ATMOSPHERE_KPA; 2]);
    let f = &model.force;
    let k = f.stiffness_mn_mm + f.stiffness_per_mass_mn_mm_g * (m.flexor_g + m.extensor_g);
    assert!(html.contains(&number(k / MN_PER_N, 1)));
}
