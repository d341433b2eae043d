use pam_baselines::joint::JointForce;
use pam_baselines::sparse_force::Polynomial;
use pam_core::ForceInput;

#[test]
fn the_slope_is_that_of_the_polynomial() {
    let p = Polynomial {
        exponents: vec![[1, 0, 0, 0], [3, 0, 0, 0], [1, 0, 1, 0]],
        coefficients: vec![1000.0, 50.0, 200.0],
        scales: [2.0, 1.0, 0.1, 1.0],
        centres: [0.0, 0.0, 0.05, 0.0],
    };
    let at = ForceInput {
        displacement_mm: 1.0,
        velocity_mm_s: 0.0,
        mass_flexor_g: 0.1,
        mass_extensor_g: 0.0,
    };
    // d/dx of 1000 (x/2) + 50 (x/2)³ + 200 (x/2) 0.5, in N/mm.
    let expected = 1e-3 * (500.0 + 50.0 * 3.0 / 8.0 + 50.0);
    let k = pam_autodiff::linearise(&p.dual(), &at).stiffness_n_mm;
    assert!((k - expected).abs() < 1e-12, "{k} {expected}");
}
