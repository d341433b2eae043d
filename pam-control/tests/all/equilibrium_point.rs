use pam_control::equilibrium_point::{EquilibriumPoint, Observation, observe};
use pam_data::Recording;

#[test]
fn a_straight_joint_is_found_and_inverted() {
    let truth = EquilibriumPoint {
        position_per_kpa: 0.006,
        position_mm: -0.05,
        stiffness_per_kpa: 0.05,
        stiffness_n_mm: 110.0,
        r2: [1.0; 2],
    };
    let observations: Vec<Observation> = [[200.0, 300.0], [400.0, 400.0], [600.0, 350.0]]
        .into_iter()
        .map(|[f, e]| {
            let (k, x0) = (0.05 * (f + e) + 110.0, 0.006 * (f - e) - 0.05);
            let mut r = Recording::empty(std::path::Path::new("made"));
            r.time_s = (0..4000).map(|i| f64::from(i) * 1e-3).collect();
            let omega = 4.0;
            for t in &r.time_s {
                let x = 0.5 * (omega * t).sin() + 0.1 * (1.7 * omega * t).cos();
                let v = 0.5 * omega * (omega * t).cos() - 0.17 * omega * (1.7 * omega * t).sin();
                let a = -0.5 * omega * omega * (omega * t).sin()
                    - 0.1 * (1.7 * omega).powi(2) * (1.7 * omega * t).cos();
                r.displacement_mm.push(x);
                r.velocity_mm_s.push(v);
                r.force_mn.push(300.0 * a + 6000.0 * v + 1e3 * k * (x - x0));
                r.pressure_flexor_kpa.push(f);
                r.pressure_extensor_kpa.push(e);
            }
            let o = observe(&r).unwrap();
            assert!((o.stiffness_n_mm - k).abs() < 1e-2 && (o.equilibrium_mm - x0).abs() < 1e-4);
            o
        })
        .collect();
    let found = EquilibriumPoint::fit(&observations).unwrap();
    assert!((found.stiffness_per_kpa - truth.stiffness_per_kpa).abs() < 1e-4);
    let [f, e] = truth.pressures_kpa(0.7, 150.0);
    assert!((0.05 * (f + e) + 110.0 - 150.0).abs() < 1e-12);
    assert!((0.006 * (f - e) - 0.05 - 0.7).abs() < 1e-12);
    assert!(EquilibriumPoint::fit(&observations[..2]).is_err());
}
