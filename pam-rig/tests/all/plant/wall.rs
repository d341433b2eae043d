use approx::assert_relative_eq;
use pam_rig::plant::WallParameters;

#[test]
fn slope_and_energy_belong_to_the_tension() {
    let wall = WallParameters::default();
    for c in [-2.5, -0.3, 0.0, 0.9, 3.0] {
        let h = 1e-4;
        let slope = (wall.tension_n(c + h) - wall.tension_n(c - h)) / (2.0 * h);
        assert_relative_eq!(wall.slope_n_mm(c), -slope, max_relative = 1e-6);
        let power = (wall.energy_mj(c + h) - wall.energy_mj(c - h)) / (2.0 * h);
        assert_relative_eq!(wall.tension_n(c), -power, max_relative = 1e-6, epsilon = 1e-6);
    }
}

#[test]
fn short_strands_are_slack() {
    let wall = WallParameters { stiffness_n_mm: 0.0, ..WallParameters::default() };
    assert!(wall.tension_n(8.0) < 1e-3);
    assert_relative_eq!(wall.slope_n_mm(-8.0), wall.toe_stiffness_n_mm, max_relative = 1e-4);
}
