//! Slow viscoelastic relaxation.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, MemoryStart, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Force `−stiffness · (x − q)`, with the damper's end q following x with the time constant.
#[derive(Debug, Clone, Copy)]
pub struct Creep;

impl Effect for Creep {
    fn info(&self) -> &'static EffectInfo {
        const { entry("creep") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, advance: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let stiffness = 0.05 * scales.stiffness_n_mm;
        let times = [0.05, 0.4, 3.0, 20.0];
        times.map(|t| vec![stiffness, t]).to_vec()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // Much shorter than the motion takes it is viscous damping.
        let motion_s = scales.travel_mm / scales.speed_mm_s.max(1e-9);
        values[1] >= (0.05 * motion_s).max(0.03)
    }

    fn memory_len(&self) -> usize {
        1
    }

    fn begin<S: Scalar>(&self, _p: &[S], at: &MemoryStart<S>, memory: &mut [S]) {
        memory[0] = at.displacement_mm;
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let mean = (at.step_start.displacement_mm + at.displacement_mm).scaled(0.5);
        let damper = relaxed(p[1], at.since_step_s, mean, memory[0]);
        // 1 N/mm = 1000 mN/mm.
        -(p[0] * (at.displacement_mm - damper)).scaled(MN_PER_N)
    }

    fn advance<S: Scalar>(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]) {
        let mean = (end.step_start.displacement_mm + end.displacement_mm).scaled(0.5);
        memory[0] = relaxed(p[1], end.since_step_s, mean, memory[0]);
    }
}

/// The damper's end after a time at a constant displacement.
fn relaxed<S: Scalar>(time_constant_s: S, time_s: f64, x: S, damper: S) -> S {
    x + (damper - x) * (-(S::constant(time_s) / time_constant_s)).exp()
}
