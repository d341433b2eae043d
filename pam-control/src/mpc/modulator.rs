//! From a wanted flow to openings of on/off valves.

use super::flow::ValveModel;
use crate::execution::{SAMPLE_S, Valve};

/// One muscle's valves: the air that was wanted and not yet let through is kept count of; when it is worth
/// half a shortest opening, a valve opens for at least that time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modulator {
    owed_g: f64,
    valve: Valve,
    left_s: f64,
}

impl Modulator {
    /// Opening of the valves in the next sample for a wanted flow (g/s), and the flow that it gives by the
    /// model, g/s.
    pub fn decide(
        &mut self,
        wanted_g_s: f64,
        pressure_kpa: f64,
        valves: &ValveModel,
    ) -> (Valve, f64) {
        let (inflow, outflow) = (valves.inflow_g_s(pressure_kpa), valves.outflow_g_s(pressure_kpa));
        // A flow that cannot be reached within a horizon is not carried over for ever.
        let most = 4.0 * valves.shortest_s * inflow.max(outflow).max(1e-6);
        self.owed_g = (self.owed_g + wanted_g_s * SAMPLE_S).clamp(-most, most);
        if self.left_s < 0.5 * SAMPLE_S {
            let worth = 0.5 * valves.shortest_s;
            // An open valve stays open until nothing is owed.
            let hurdle = if self.valve == Valve::Shut { 1.0 } else { 0.01 };
            let next = if self.owed_g > hurdle * worth * inflow && inflow > 0.0 {
                Valve::Inflate
            } else if -self.owed_g > hurdle * worth * outflow && outflow > 0.0 {
                Valve::Exhaust
            } else {
                Valve::Shut
            };
            if next != self.valve && next != Valve::Shut {
                self.left_s = valves.shortest_s;
            }
            self.valve = next;
        }
        self.left_s -= SAMPLE_S;
        let flow = match self.valve {
            Valve::Shut => 0.0,
            Valve::Inflate => inflow,
            Valve::Exhaust => -outflow,
        };
        self.owed_g -= flow * SAMPLE_S;
        (self.valve, flow)
    }
}
