use approx::assert_relative_eq;
use pam_rig::plant::{LossParameters, MaxwellSlip};

fn drive(slip: &mut MaxwellSlip, limit: f64, turns: &[f64], steps: usize) -> f64 {
    let mut at = 0.0;
    for &to in turns {
        for _ in 0..steps {
            slip.advance((to - at) / steps as f64, limit);
        }
        at = to;
    }
    slip.force_n()
}

/// Madelung's rules: the force depends on the turning points alone, and a closed minor loop is
/// forgotten.
#[test]
fn memory_is_of_turning_points_and_wiped_out_by_larger_loops() {
    let p = LossParameters::default();
    let limit = p.dry_limit_n(310.0);
    let fresh = MaxwellSlip::new(&p);
    let fast = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8], 1);
    let slow = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8], 1000);
    assert_relative_eq!(fast, slow, max_relative = 1e-9);
    let with_loop = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8, 0.6, 0.3], 7);
    let without = drive(&mut fresh.clone(), limit, &[1.0, 0.3], 7);
    assert_relative_eq!(with_loop, without, max_relative = 1e-9);
}

#[test]
fn the_force_saturates_at_the_limit_after_the_longest_slip() {
    let p = LossParameters::default();
    let limit = p.dry_limit_n(310.0);
    let mut slip = MaxwellSlip::new(&p);
    slip.advance(0.9 * p.slip_mm[1], limit);
    assert!(slip.force_n() < limit);
    slip.advance(0.11 * p.slip_mm[1], limit);
    assert_relative_eq!(slip.force_n(), limit, max_relative = 1e-12);
}
