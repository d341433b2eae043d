//! The forces that the truth names are those that move the joint.

use crate::common::{MASS_KG, ideal, sealed, sine, unknown_force};

/// Mass times acceleration is motor, tendons and friction, taut or slack, at all pressures.
#[test]
fn the_forces_of_the_truth_account_for_the_motion() {
    let mut slack = 0;
    for (psi, current_a) in [([10.0, 10.0], 3.0), ([45.0, 45.0], 1.5), ([80.0, 10.0], 2.0)] {
        let frames = sealed(&ideal(&[]), psi, 6.0, sine(current_a, 1.0));
        let truth = |k: usize| &frames[k].truth;
        let taut = |k: usize| truth(k).tensions_n.map(|t| t > 0.0);
        // Forces jump where the joint stops or turns, and where a tendon is caught.
        let smooth = |k: &usize| {
            let slides =
                |a: usize, b: usize| truth(a).velocity_mm_s * truth(b).velocity_mm_s > 1e-2;
            slides(k - 1, *k)
                && slides(*k, k + 1)
                && taut(k - 1) == taut(*k)
                && taut(*k) == taut(k + 1)
        };
        // Entry k − 1 belongs to sample k.
        let unknown = unknown_force(&frames, MASS_KG).into_iter().zip(1..);
        let off: Vec<f64> =
            unknown.filter(|(_, k)| smooth(k)).map(|(u, _)| u.force_n.abs()).collect();
        assert!(off.len() > 3000, "{}", off.len());
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let worst = off.iter().copied().fold(0.0, f64::max);
        assert!(mean < 0.01 && worst < 0.2, "{psi:?}: {mean} N in the mean, {worst} N at most");
        slack += (0..frames.len()).filter(|k| taut(*k) != [true; 2]).count();
    }
    assert!(slack > 1000, "hardly a slack tendon in {slack} samples");
}
