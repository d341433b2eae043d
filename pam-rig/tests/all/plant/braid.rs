use approx::assert_relative_eq;
use pam_rig::plant::{Braid, BraidParameters};
use std::f64::consts::PI;

#[test]
fn the_force_is_the_one_of_chou_and_hannaford() {
    let p = BraidParameters::default();
    let braid = Braid::new(&p);
    let angle = p.angle_deg.to_radians();
    for contraction in [-3.0, 0.0, 2.0, 20.0] {
        let strain = contraction / p.length_mm;
        let area = 0.25 * PI * p.diameter_mm * p.diameter_mm;
        let expected =
            area * (3.0 * (1.0 - strain).powi(2) / angle.tan().powi(2) - 1.0 / angle.sin().powi(2));
        assert_relative_eq!(braid.area_mm2(contraction), expected, max_relative = 1e-12);
    }
}

#[test]
fn areas_are_slopes_of_the_volume() {
    let braid = Braid::new(&BraidParameters::default());
    for c in [-2.0, 0.0, 5.0] {
        let h = 1e-3;
        let slope = (braid.volume_mm3(c + h) - braid.volume_mm3(c - h)) / (2.0 * h);
        assert_relative_eq!(braid.area_mm2(c), slope, max_relative = 1e-7);
        let slope = (braid.area_mm2(c + h) - braid.area_mm2(c - h)) / (2.0 * h);
        assert_relative_eq!(braid.area_slope_mm(c), slope, max_relative = 1e-7);
    }
}

#[test]
fn at_rest_the_gas_fills_bore_and_dead_volume() {
    let p = BraidParameters::default();
    let expected = PI * 25.0 * 200.0 + p.dead_volume_mm3;
    assert_relative_eq!(Braid::new(&p).volume_mm3(0.0), expected, max_relative = 1e-12);
}
