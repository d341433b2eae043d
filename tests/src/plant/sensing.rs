//! Play, lags, delays, gains and offsets between the joint and the recorded columns.

use super::acting::Acting;
use super::laws::{Kept, Moment};
use super::motion::Joint;
use super::{ATMOSPHERE_KPA, Hidden};

/// Values of the last steps, read back with interpolation.
#[derive(Debug, Clone)]
struct Delay {
    past: Vec<f64>,
    newest: usize,
}

impl Delay {
    fn new(longest_steps: usize, value: f64) -> Self {
        Self { past: vec![value; longest_steps + 2], newest: 0 }
    }

    fn push(&mut self, value: f64) {
        self.newest = (self.newest + 1) % self.past.len();
        self.past[self.newest] = value;
    }

    /// The value of `steps` steps ago.
    fn ago(&self, steps: f64) -> f64 {
        let len = self.past.len();
        let at = |back: usize| self.past[(self.newest + len - back.min(len - 1)) % len];
        let whole = steps as usize;
        let share = steps - whole as f64;
        if share == 0.0 { at(whole) } else { (1.0 - share) * at(whole) + share * at(whole + 1) }
    }
}

/// The sensors of displacement and pressures.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    dt: f64,
    /// What stands behind the play, mm.
    shown_mm: f64,
    /// Inputs of the lags at the last step, and their outputs: x, P_f, P_e.
    input: [f64; 3],
    lagged: [f64; 3],
    delays: [Delay; 3],
    frozen_mm: f64,
    /// Force of the motor, which some sensors feel, mN.
    motor_mn: f64,
    /// Velocity, which some sensors feel, mm/s.
    v: f64,
    /// What laws remember, which some sensors feel.
    kept: Kept,
}

impl Chain {
    /// Sensors that have seen the joint at rest for long.
    pub(super) fn new(joint: &Joint, acting: &Acting, effects: &[Hidden], dt: f64) -> Self {
        let input = [joint.x, joint.pressures_kpa[0], joint.pressures_kpa[1]];
        let longest_ms = effects.iter().map(|h| h.get("delay_ms")).fold(0.0, f64::max);
        let steps = (1e-3 * longest_ms / dt).ceil() as usize;
        let mut chain = Self {
            dt,
            shown_mm: joint.x,
            input,
            lagged: input,
            delays: input.map(|value| Delay::new(steps, value)),
            frozen_mm: joint.x,
            motor_mn: joint.motor_mn,
            v: joint.v,
            kept: joint.kept,
        };
        chain.frozen_mm = chain.displacement(acting);
        chain
    }

    /// Follows the joint through a step.
    pub(super) fn step(&mut self, joint: &Joint, acting: &Acting, dt: f64) {
        self.motor_mn = joint.motor_mn;
        self.v = joint.v;
        self.kept = joint.kept;
        let half = acting.half_gap_mm;
        self.shown_mm = self.shown_mm.clamp(joint.x - half, joint.x + half);
        let input = [self.shown_mm, joint.pressures_kpa[0], joint.pressures_kpa[1]];
        let rates = [acting.position_rate, acting.pressure_rate, acting.pressure_rate];
        for i in 0..3 {
            // The exact response to an input that is linear over the step; without a lag the input itself.
            let w = rates[i] * dt;
            self.lagged[i] = if w.is_infinite() {
                input[i]
            } else {
                let decay = (-w).exp();
                let slope = (input[i] - self.input[i]) / w;
                input[i] - slope + (self.lagged[i] - self.input[i] + slope) * decay
            };
            self.input[i] = input[i];
            self.delays[i].push(self.lagged[i]);
        }
    }

    fn displacement(&self, acting: &Acting) -> f64 {
        let x = self.delays[0].ago(acting.position_delay_s / self.dt);
        let kpa = [self.input[1], self.input[2]];
        let x = acting.laws.reading_mm(x, kpa, self.kept, self.motor_mn);
        (1.0 + acting.position_gain) * x + acting.offset_mm
    }

    /// Displacement (mm) and pressures (kPa) as the sensors show them at `t`, before their noise.
    pub(super) fn read(&mut self, acting: &Acting, t: f64) -> [f64; 3] {
        let mut x = self.displacement(acting);
        if let Some([period, duration]) = acting.freeze
            && t > period
            && t % period < duration
        {
            x = self.frozen_mm;
        }
        self.frozen_mm = x;
        let steps = acting.pressure_delay_s / self.dt;
        let kpa = [0, 1].map(|i| self.delays[i + 1].ago(steps));
        let x_now = self.delays[0].ago(0.0);
        let now = Moment { x: x_now, v: self.v, t, kpa, motor_mn: self.motor_mn };
        let shown = acting.laws.readings(now);
        let [flexor, extensor] = [0, 1].map(|i| {
            let p = shown[i];
            p + acting.pressure_gain[i] * (p - ATMOSPHERE_KPA) + acting.pressure_bias_kpa[i]
        });
        [x, flexor, extensor]
    }
}
