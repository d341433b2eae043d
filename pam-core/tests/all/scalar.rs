use approx::assert_relative_eq;
use num_dual::{Dual64, HyperDual64};
use pam_core::Scalar;

fn softplus_of<S: Scalar>(x: S) -> S {
    x.softplus()
}

#[test]
fn softplus_and_its_inverse_cover_all_magnitudes() {
    for x in [-800.0_f64, -30.0, -1.0, 0.0, 1.0, 30.0, 304.6, 8.47e7] {
        let y = softplus_of(x);
        assert!(y.is_finite() && y >= 0.0);
        if y > 1e-12 {
            assert_relative_eq!(y.softplus_inverse(), x, epsilon = 1e-9, max_relative = 1e-12);
        }
    }
    assert_relative_eq!(softplus_of(3.6657095_f64), 3.690974, max_relative = 1e-6);
}

#[test]
fn softplus_differentiates_to_the_sigmoid() {
    for x in [-40.0, -0.5, 0.0, 0.5, 40.0] {
        let d = softplus_of(Dual64::new(x, 1.0));
        assert_relative_eq!(d.eps, x.sigmoid(), max_relative = 1e-14);
        let h = softplus_of(HyperDual64::new(x, 1.0, 1.0, 0.0));
        let s = x.sigmoid();
        assert_relative_eq!(h.eps1eps2, s * (-x).sigmoid(), max_relative = 1e-12);
    }
}

#[test]
fn comparisons_look_at_real_parts() {
    let a = Dual64::new(1.0, 5.0);
    let b = Dual64::new(2.0, 7.0);
    assert_eq!(a.maximum(b).eps, 7.0);
    assert_eq!(a.minimum(b).eps, 5.0);
    assert_eq!(b.clamped(Dual64::constant(0.0), Dual64::constant(1.5)).eps, 0.0);
}
