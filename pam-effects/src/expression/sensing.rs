//! What sensors read: expressions of the true channels and of what the sensors remember.

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
    /// Readings at rest and their slopes by what is read: position, flexor, extensor; `None` where the reading is right.
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
    /// Takes the effect out of the readings at rest and at the start: Newton steps for what was there.
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

    /// Turns true series into readings. What the sensors remember moves by `law`, along what was measured before if the series are a
    /// part of a recording.
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
        let mut before = [S::zero(); VARIABLES];
        if let (Some(law), Some(measured)) = (law, seen.before) {
            for (k, (time_s, point)) in measured.timed().enumerate() {
                let now = variables_of(time_s, &point);
                match k {
                    0 => law
                        .starts
                        .values(&Row { variables: &now, p, memory: &[] }, &mut memory[..len]),
                    _ => sensed(law, p, [&before, &now], measured.step_s, &mut memory),
                }
                before = now;
            }
        }
        for k in 0..seen.displacement_mm.len() {
            let mut now = [S::zero(); VARIABLES];
            (now[X], now[V]) = (seen.displacement_mm[k], seen.velocity_mm_s[k]);
            (now[PF], now[PE]) = (seen.pressures_kpa[0][k], seen.pressures_kpa[1][k]);
            now[T] = S::constant(seen.start_s + step_s * k as f64);
            now[FORCE] = S::constant(seen.force_n(k));
            match law {
                // The last point that was measured before is the first one here.
                Some(law) if k == 0 && seen.before.is_none() => {
                    let start = Row { variables: &now, p, memory: &[] };
                    law.starts.values(&start, &mut memory[..len]);
                }
                Some(law) if k > 0 => sensed(law, p, [&before, &now], step_s, &mut memory),
                _ => {}
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
            before = now;
        }
        if matches!(velocity, Velocity::Difference) {
            seen.renew_velocity();
        }
    }
}

/// What was measured at a time since the excitation began, s, as the variables of a sensor.
fn variables_of<S: Scalar>(time_s: f64, point: &MeasuredPoint) -> [S; VARIABLES] {
    let c = S::constant;
    let mut now = [S::zero(); VARIABLES];
    (now[X], now[V]) = (c(point.displacement_mm), c(point.velocity_mm_s));
    [now[PF], now[PE]] = point.pressures_kpa.map(c);
    (now[T], now[FORCE]) = (c(time_s), c(point.force_mn / MN_PER_N));
    now
}

/// Moves what a sensor remembers from one instant to the next, `step_s` later.
fn sensed<S: Scalar>(
    law: &Memory,
    p: &[S],
    [before, now]: [&[S; VARIABLES]; 2],
    step_s: f64,
    memory: &mut [S; MOST],
) {
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
