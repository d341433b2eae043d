use num_dual::Dual64;
use pam_autodiff::linearise;
use pam_control::stiffness::ExactMap;
use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, AnyForce, ForceInput, JointModel, NetworkForce, Scalar, SealedMasses};

/// 100 N/mm, and 80 N/mm more where x is positive: two halves, with slopes as by dual numbers.
#[test]
fn halves_of_a_spring_with_one_kink() {
    let rows = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0];
    let hidden = Dense::from_rows(&rows, vec![0.0, 0.0]).unwrap();
    let output = Dense::from_rows(&[180e3, -100e3], vec![0.0]).unwrap();
    let mlp = Mlp::new(vec![hidden, output], Activation::from_name("relu").unwrap()).unwrap();
    let model = JointModel::datasheet(AnyForce::Network(NetworkForce::new(mlp).unwrap()));
    let masses = SealedMasses { flexor_g: 0.08, extensor_g: 0.08 };
    let map = ExactMap::new(&model, "two".into(), masses, [2.0, 10.0]).unwrap();
    assert!(map.partition.uncovered_share.abs() < 1e-12, "{}", map.partition.uncovered_share);
    let mut found: Vec<(f64, f64)> =
        map.partition.regions.iter().map(|p| (p.force[1], p.area)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(found, [(100e3, 40.0), (180e3, 40.0)]);
    for polygon in &map.partition.regions {
        let count = polygon.vertices.len() as f64;
        let middle: [f64; 2] =
            std::array::from_fn(|i| polygon.vertices.iter().map(|c| c[i]).sum::<f64>() / count);
        let at = ForceInput {
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
            displacement_mm: middle[0],
            velocity_mm_s: middle[1],
        };
        let slopes = linearise(&model.force.map(Dual64::constant), &at);
        assert!((1e3 * slopes.stiffness_n_mm - polygon.force[1]).abs() < 1e-9);
    }
}
