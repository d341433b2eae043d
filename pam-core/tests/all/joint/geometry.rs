use approx::assert_relative_eq;
use num_dual::Dual64;
use pam_core::MuscleGeometry;
use pam_core::Scalar;

#[test]
fn slopes_are_the_derivatives_of_the_volumes() {
    let g = MuscleGeometry::default();
    for x in [-5.0, -1.2, 0.0, 0.4, 3.0] {
        let plain = g.volumes(x, 3.69);
        let dual = g.volumes(Dual64::new(x, 1.0), Dual64::constant(3.69));
        assert_relative_eq!(plain.flexor_slope_mm2, dual.flexor_mm3.eps, max_relative = 1e-13);
        assert_relative_eq!(plain.extensor_slope_mm2, dual.extensor_mm3.eps, max_relative = 1e-13);
    }
}

#[test]
fn slopes_by_deformation_are_derivatives_too() {
    let g = MuscleGeometry::default();
    for x in [-5.0, -1.2, 0.0, 0.4, 3.0] {
        let dual = g.volumes(Dual64::constant(x), Dual64::new(3.69, 1.0));
        let [flexor, extensor] = g.volume_slopes_by_deformation(x, 3.69);
        assert_relative_eq!(flexor, dual.flexor_mm3.eps, max_relative = 1e-13);
        assert_relative_eq!(extensor, dual.extensor_mm3.eps, max_relative = 1e-13);
    }
}

#[test]
fn the_muscles_mirror_each_other() {
    let g = MuscleGeometry::default();
    let (a, b) = (g.volumes(1.3, 3.69), g.volumes(-1.3, 3.69));
    assert_relative_eq!(a.flexor_mm3, b.extensor_mm3, max_relative = 1e-14);
    assert_relative_eq!(a.flexor_slope_mm2, -b.extensor_slope_mm2, max_relative = 1e-14);
    let nominal = g.volumes(0.0, 3.69).flexor_mm3;
    assert_relative_eq!(nominal, std::f64::consts::PI * 25.0 * 200.0, max_relative = 1e-14);
}
