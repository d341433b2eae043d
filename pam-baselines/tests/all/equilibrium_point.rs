use pam_baselines::equilibrium_point::EquilibriumForce;
use pam_control::equilibrium_point::EquilibriumPoint;
use pam_core::ForceInput;

/// ∂f/∂x is the model's own K.
#[test]
fn the_derivative_is_the_published_line() {
    let force = EquilibriumForce {
        point: EquilibriumPoint {
            position_per_kpa: 0.006,
            position_mm: -0.05,
            stiffness_per_kpa: 0.05,
            stiffness_n_mm: 110.0,
            r2: [1.0; 2],
        },
        damping_kg_s: 5000.0,
        pressure_per_mass_kpa_g: 5000.0,
    };
    let at = ForceInput {
        displacement_mm: 0.3,
        velocity_mm_s: 0.0,
        mass_flexor_g: 0.08,
        mass_extensor_g: 0.06,
    };
    let k = pam_autodiff::linearise(&force, &at).stiffness_n_mm;
    assert!((k - (0.05 * 700.0 + 110.0)).abs() < 1e-9, "{k}");
}
