//! An effect: a place in which the joint catches.

use pam_cli::own::{DataScales, Effect, EffectInfo, Group, ParameterInfo, Point, Scalar, units};

const INFO: EffectInfo = EffectInfo::new(
    "detent",
    Group::Mechanics,
    "a place in which the joint catches",
    &[
        ParameterInfo::linear("force_n", [0.0, 200.0]),
        ParameterInfo::linear("position_mm", [-10.0, 10.0]),
    ],
)
.excited_by("slow motion through the place");

/// Width of the place, mm.
const WIDTH_MM: f64 = 0.2;

/// Force `−F d e^((1 − d²) / 2)` with `d = (x − position) / width`: it is `F` at its largest, one width away.
#[derive(Debug, Clone, Copy)]
pub struct Detent;

impl Effect for Detent {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    // Where a fit begins.
    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        [-0.5, 0.0, 0.5].map(|position_mm| vec![5.0, position_mm]).to_vec()
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        let d = (at.displacement_mm - p[1]).scaled(1.0 / WIDTH_MM);
        let shape = ((S::constant(1.0) - d * d).scaled(0.5)).exp();
        -(p[0] * d * shape).scaled(units::MN_PER_N)
    }
}
