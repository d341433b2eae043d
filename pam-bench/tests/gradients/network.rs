//! The networks of the problems.

use pam_bench::gradients::problems::network::{force, target_mn};
use pam_core::{Activation, ForceInput, ForceModel};

/// Every network restores and damps, and the wider ones are close to what they are fitted to.
#[test]
fn networks_behave_like_a_joint() {
    let _alone = super::alone();
    for name in Activation::NAMES {
        for width in [8, 32] {
            let force = force(Activation::from_name(name).unwrap(), width);
            let mut work = vec![0.0; force.work_len()];
            let mut at = |x: f64, v: f64| {
                let (m, n) = (0.08, 0.07);
                let input = ForceInput {
                    displacement_mm: x,
                    velocity_mm_s: v,
                    mass_flexor_g: m,
                    mass_extensor_g: n,
                };
                (force.restoring_force_mn(&input, &mut work), target_mn([m, n, x, v]))
            };
            let stiffness = (at(0.5, 0.0).0 - at(-0.5, 0.0).0) / 1e3;
            let damping = (at(0.0, 10.0).0 - at(0.0, -10.0).0) / 20.0;
            // A narrow network only has to push back.
            let (stiff, damped) =
                if width == 32 { (90.0..240.0, 4500.0..8500.0) } else { (20.0..500.0, 1e3..2e4) };
            assert!(stiff.contains(&stiffness), "{name} {width}: {stiffness} N/mm");
            assert!(damped.contains(&damping), "{name} {width}: {damping} kg/s");
            if width == 32 {
                let (found, wanted) = at(0.4, -7.0);
                assert!((found - wanted).abs() < 2.5e4, "{name}: {found} for {wanted} mN");
            }
        }
    }
}
