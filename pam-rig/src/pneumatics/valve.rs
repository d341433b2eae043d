//! Solenoid valves with sonic conductance.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Density of air at the reference atmosphere of ISO 8778 (100 kPa, 20 °C, 65 % humidity), g/dm³.
const REFERENCE_DENSITY_G_DM3: f64 = 1.185;
/// Temperature of the reference atmosphere, K.
const REFERENCE_K: f64 = 293.15;
/// Pressure ratio above which the flow is linear, so that it is smooth at equal pressures.
const LINEAR_FROM: f64 = 0.999;

/// Mass flow through an orifice, g/s (ISO 6358-1:2013, equations 1 and 2):
///
/// ```text
/// ṁ = C ρ₀ p₁ √(T₀/T₁) · { 1                              p₂/p₁ ≤ b
///                         { √(1 − ((p₂/p₁ − b)/(1 − b))²)  else
/// ```
///
/// `conductance` C in dm³/(s·bar), pressures absolute in kPa, upstream temperature in K; `p₂ ≤ p₁`.
#[must_use]
pub fn iso_6358_flow_g_s(
    conductance: f64,
    critical_ratio: f64,
    upstream_kpa: f64,
    upstream_k: f64,
    downstream_kpa: f64,
) -> f64 {
    let ratio = downstream_kpa / upstream_kpa;
    if ratio >= 1.0 {
        return 0.0;
    }
    let subsonic = |ratio: f64| {
        let place = ((ratio - critical_ratio) / (1.0 - critical_ratio)).max(0.0);
        (1.0 - place * place).sqrt()
    };
    let share = if ratio > LINEAR_FROM {
        subsonic(LINEAR_FROM) * (1.0 - ratio) / (1.0 - LINEAR_FROM)
    } else {
        subsonic(ratio)
    };
    let choked = conductance
        * REFERENCE_DENSITY_G_DM3
        * (1e-2 * upstream_kpa)
        * (REFERENCE_K / upstream_k).sqrt();
    choked * share
}

/// Parameters of a pair of valves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValveParameters {
    /// Sonic conductance of valve and tube from the supply into the muscle, dm³/(s·bar).
    pub inflate_conductance: f64,
    /// Sonic conductance out of the muscle, dm³/(s·bar).
    pub exhaust_conductance: f64,
    /// Critical pressure ratio b.
    pub critical_ratio: f64,
    /// Time from command to opening and to closing, ms.
    pub response_ms: f64,
}

/// Conductances from the slew rate that the published tracking runs need, see `docs/rig.md`.
impl Default for ValveParameters {
    fn default() -> Self {
        Self {
            inflate_conductance: 0.020,
            exhaust_conductance: 0.020,
            critical_ratio: 0.3,
            response_ms: 2.0,
        }
    }
}

/// Opening of the valves of a muscle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Opening {
    /// Both shut.
    #[default]
    Shut,
    /// Open to the supply.
    Inflate,
    /// Open to the room.
    Exhaust,
}

/// The valves of one muscle, which follow their command with a delay.
#[derive(Debug, Clone)]
pub struct Valve {
    parameters: ValveParameters,
    pending: VecDeque<Opening>,
    delay_steps: usize,
}

/// State of the air at one side of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirState {
    /// Absolute pressure, kPa.
    pub pressure_kpa: f64,
    /// Temperature, K.
    pub temperature_k: f64,
}

/// Mass flows of a valve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ValveFlow {
    /// Into the muscle, negative if it leaves, g/s.
    pub into_muscle_g_s: f64,
    /// Out of the supply, g/s.
    pub from_supply_g_s: f64,
}

impl Valve {
    /// Shut valves, stepped every `step_s`.
    #[must_use]
    pub fn new(parameters: ValveParameters, step_s: f64) -> Self {
        let delay_steps = (1e-3 * parameters.response_ms / step_s).round() as usize;
        Self { parameters, pending: VecDeque::new(), delay_steps }
    }

    /// Mass flow during a step for a command.
    pub fn flow(
        &mut self,
        command: Opening,
        supply: AirState,
        muscle: AirState,
        room_kpa: f64,
    ) -> ValveFlow {
        self.pending.push_back(command);
        let now = if self.pending.len() > self.delay_steps {
            self.pending.pop_front().unwrap_or_default()
        } else {
            Opening::Shut
        };
        let p = &self.parameters;
        match now {
            Opening::Shut => ValveFlow::default(),
            Opening::Inflate => {
                let flow = iso_6358_flow_g_s(
                    p.inflate_conductance,
                    p.critical_ratio,
                    supply.pressure_kpa,
                    supply.temperature_k,
                    muscle.pressure_kpa,
                );
                ValveFlow { into_muscle_g_s: flow, from_supply_g_s: flow }
            }
            Opening::Exhaust => {
                let flow = iso_6358_flow_g_s(
                    p.exhaust_conductance,
                    p.critical_ratio,
                    muscle.pressure_kpa,
                    muscle.temperature_k,
                    room_kpa,
                );
                ValveFlow { into_muscle_g_s: -flow, from_supply_g_s: 0.0 }
            }
        }
    }
}
