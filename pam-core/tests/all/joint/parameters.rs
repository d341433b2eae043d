use approx::assert_relative_eq;
use pam_core::{PhysicalParameters, RawParameters};

#[test]
fn published_raw_values_give_the_published_parameters() {
    let raw = RawParameters { mass: 304.648_28, gas_coefficient: 8.47e7, deformation: 3.665_709_5 };
    let p = raw.physical();
    assert_relative_eq!(p.mass_kg, 304.648, max_relative = 2e-6);
    assert_relative_eq!(p.gas_coefficient, 8.47e7, max_relative = 1e-12);
    assert_relative_eq!(p.deformation, 3.690_974, max_relative = 1e-6);
}

#[test]
fn raw_and_physical_are_inverse() {
    let p = PhysicalParameters::datasheet();
    let back = p.to_raw().physical();
    assert_relative_eq!(back.mass_kg, p.mass_kg, max_relative = 1e-14);
    assert_relative_eq!(back.gas_coefficient, p.gas_coefficient, max_relative = 1e-14);
    assert_relative_eq!(back.deformation, p.deformation, max_relative = 1e-14);
}
