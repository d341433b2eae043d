use crate::common::published;
use pam_control::synthesis::{
    CertifiedSynthesiser, MassBounds, Solution, SynthesisSettings, Synthesiser, Target,
};

/// Never farther from the wanted stiffness than the general solver, which follows the curve, and at
/// the same force; every certificate is complete.
#[test]
fn is_never_worse_than_the_followed_curve() {
    let model = published();
    let settings = SynthesisSettings::published(MassBounds::trained(&model));
    let targets: Vec<Target> = (0..24)
        .map(|k| {
            let phase = 0.26 * f64::from(k);
            Target {
                time_s: 0.1 * f64::from(k),
                displacement_mm: 1.5 * phase.sin(),
                velocity_mm_s: 3.0 * phase.cos(),
                acceleration_mm_s2: -6.0 * phase.sin(),
                stiffness_n_mm: 120.0 + 3.0 * f64::from(k),
                load_mn: 0.0,
            }
        })
        .collect();
    let general = Synthesiser::new(&model, settings).unwrap().solve(&targets).unwrap();
    let certified = CertifiedSynthesiser::new(&model, settings).unwrap().solve(&targets).unwrap();
    for ((t, g), (c, proof)) in targets.iter().zip(&general).zip(&certified) {
        assert!(proof.is_complete(), "{proof:?}");
        assert!(c.residual_mn.abs() < 1e-6, "{c:?}");
        let miss = |s: &Solution| (s.stiffness_n_mm - t.stiffness_n_mm).abs();
        assert!(miss(c) <= miss(g) + 1e-6, "{c:?} {g:?}");
    }
}
