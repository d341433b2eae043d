use approx::assert_relative_eq;
use pam_core::units::{
    MN_PER_N, datasheet_deformation_coefficient, datasheet_reflected_mass_kg, tendon_force_mn_per_a,
};

#[test]
fn datasheet_values_match_the_paper() {
    assert_relative_eq!(datasheet_reflected_mass_kg(), 253.9, max_relative = 1e-3);
    assert_relative_eq!(datasheet_deformation_coefficient(), 4.60, max_relative = 1e-3);
    assert_relative_eq!(tendon_force_mn_per_a() / MN_PER_N, 133.5, max_relative = 1e-3);
}
