//! Sensor readings: expressions of the true channels and of the sensors' memory states.

use super::joint::{DT, DX, FORCE, PE, PF, Row, T, V, VARIABLES, X, X0};
use super::memory::{MOST, Memory};
use crate::effects::{MeasuredPoint, Observed, Rest};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_expression::Program;

/// Readings of the sensors.
#[derive(Debug, Default)]
pub(super) struct Sensors {
    pub(super) position_mm: Option<Program>,
    pub(super) velocity: Velocity,
    pub(super) pressures_kpa: [Option<Program>; 2],
    /// Reading at rest and its derivative with respect to the true value, of position, flexor and extensor; `None` where the reading is
    /// the true value.
    pub(super) rest: [Option<Program>; 3],
}

/// How the velocity is read.
#[derive(Debug, Default)]
pub(super) enum Velocity {
    /// As it is.
    #[default]
    True,
    /// By an expression: given, or the derivative of the position's.
    Of(Program),
    /// As the difference of two positions.
    Difference,
}

/// Newton steps for the true reading at rest; a straight line takes one.
const NEWTON_STEPS: usize = 8;

impl Sensors {
    /// Replaces the readings at rest and at the start by the true values, with Newton's method.
    pub(super) fn undo<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        let readings = [
            ([0.0, 0.0], &mut rest.sealed_mm, &mut rest.sealed_kpa),
            ([rest.start_s, rest.start_force_mn], &mut rest.start_mm, &mut rest.start_kpa),
        ];
        for ([time_s, force_mn], displacement, [flexor, extensor]) in readings {
            let measured = [*displacement, *flexor, *extensor];
            let mut variables = [S::zero(); VARIABLES];
            (variables[T], variables[FORCE]) =
                (S::constant(time_s), S::constant(force_mn / MN_PER_N));
            (variables[X], variables[PF], variables[PE]) = (measured[0], measured[1], measured[2]);
            for ((program, reading), of) in self.rest.iter().zip(measured).zip([X, PF, PE]) {
                let Some(program) = program else { continue };
                for _ in 0..NEWTON_STEPS {
                    let mut found = [S::zero(); 2];
                    program.values(&Row { variables: &variables, p, memory: &[] }, &mut found);
                    let [value, slope] = found;
                    if slope.real() == 0.0 || !slope.real().is_finite() {
                        break;
                    }
                    variables[of] -= (value - reading) / slope;
                }
            }
            (*displacement, *flexor, *extensor) = (variables[X], variables[PF], variables[PE]);
        }
    }

    /// Replaces true series by readings. The memory states follow `law`, first along the measured history if the series belong to a part
    /// of a recording.
    pub(super) fn observe<S: Scalar>(
        &self,
        law: Option<&Memory>,
        p: &[S],
        seen: &mut Observed<'_, S>,
    ) {
        let step_s = seen.step_s;
        let Self { position_mm, velocity, pressures_kpa, .. } = self;
        if position_mm.is_none()
            && matches!(velocity, Velocity::True)
            && pressures_kpa.iter().all(Option::is_none)
        {
            return;
        }
        let mut memory = [S::zero(); MOST];
        let len = law.map_or(0, |law| law.len);
        let mut before = None;
        if let (Some(law), Some(measured)) = (law, seen.before) {
            for (time_s, point) in measured.timed() {
                let now = variables_of(time_s, &point);
                remember(law, p, before.as_ref(), &now, measured.step_s, &mut memory);
                before = Some(now);
            }
        }
        for k in 0..seen.displacement_mm.len() {
            let mut now = [S::zero(); VARIABLES];
            (now[X], now[V]) = (seen.displacement_mm[k], seen.velocity_mm_s[k]);
            (now[PF], now[PE]) = (seen.pressures_kpa[0][k], seen.pressures_kpa[1][k]);
            now[T] = S::constant(seen.start_s + step_s * k as f64);
            now[FORCE] = S::constant(seen.force_n(k));
            // The last point of the history is the first one here.
            let is_known = k == 0 && seen.before.is_some();
            if let Some(law) = law.filter(|_| !is_known) {
                remember(law, p, before.as_ref(), &now, step_s, &mut memory);
            }
            let row = Row { variables: &now, p, memory: &memory[..len] };
            if let Velocity::Of(program) = velocity {
                seen.velocity_mm_s[k] = program.value(&row);
            }
            if let Some(program) = position_mm {
                seen.displacement_mm[k] = program.value(&row);
            }
            for (series, program) in seen.pressures_kpa.iter_mut().zip(pressures_kpa) {
                if let Some(program) = program {
                    series[k] = program.value(&row);
                }
            }
            before = Some(now);
        }
        if matches!(velocity, Velocity::Difference) {
            seen.renew_velocity();
        }
    }
}

/// The variables of a sensor at a measured point; `time_s` counts from the start of the excitation.
fn variables_of<S: Scalar>(time_s: f64, point: &MeasuredPoint) -> [S; VARIABLES] {
    let c = S::constant;
    let mut now = [S::zero(); VARIABLES];
    (now[X], now[V]) = (c(point.displacement_mm), c(point.velocity_mm_s));
    [now[PF], now[PE]] = point.pressures_kpa.map(c);
    (now[T], now[FORCE]) = (c(time_s), c(point.force_mn / MN_PER_N));
    now
}

/// Moves the memory states of a sensor to an instant: from the one before, `step_s` earlier, or to their starting values.
fn remember<S: Scalar>(
    law: &Memory,
    p: &[S],
    before: Option<&[S; VARIABLES]>,
    now: &[S; VARIABLES],
    step_s: f64,
    memory: &mut [S; MOST],
) {
    let Some(before) = before else {
        law.starts.values(&Row { variables: now, p, memory: &[] }, &mut memory[..law.len]);
        return;
    };
    let mut end = *now;
    end[DT] = S::constant(step_s);
    (end[DX], end[X0]) = (now[X] - before[X], before[X]);
    let evaluate = |memory: &[S], start: bool, program: &Program, out: &mut [S]| {
        let variables = if start { before } else { &end };
        program.values(&Row { variables, p, memory }, out);
    };
    let old = *memory;
    law.advance(step_s, &old[..law.len], &evaluate, |moved| {
        memory[..law.len].copy_from_slice(moved);
    });
}
