use approx::assert_relative_eq;
use num_dual::Dual64;
use pam_autodiff::{FourPointSmoothed, linearise, stiffness_by_difference_n_mm};
use pam_core::Scalar;
use pam_core::{ForceInput, SpringDamper};

#[test]
fn a_spring_damper_has_its_own_slopes() {
    let force = SpringDamper::constant(150e3, 6500.0);
    let at = ForceInput {
        displacement_mm: 0.4,
        velocity_mm_s: -2.0,
        mass_flexor_g: 0.05,
        mass_extensor_g: 0.06,
    };
    let line = linearise(&force.map(Dual64::constant), &at);
    assert_relative_eq!(line.stiffness_n_mm, 150.0, max_relative = 1e-15);
    assert_relative_eq!(line.damping_kg_s, 6500.0, max_relative = 1e-15);
    assert_relative_eq!(line.force_mn, 150e3 * 0.4 - 13e3, max_relative = 1e-14);
    let fd = stiffness_by_difference_n_mm(&force, &at, &FourPointSmoothed::default());
    assert_relative_eq!(fd, 150.0, max_relative = 1e-12);
}
