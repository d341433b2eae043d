use super::flow::ValveModel;
use super::horizon::{Horizon, HorizonSettings, Reference};
use super::modulator::Modulator;
use super::observer::{Belief, Observer, ObserverSettings};
use crate::error::ControlError;
use crate::execution::{Air, Joint, JointCommand, Reading, SAMPLE_S, Valve};
use crate::motion::Motion;
use crate::synthesis::{AnyBatch, MassBounds};
use pam_core::{AnyForce, JointModel};
use pam_numerics::statistics::quantile;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Settings of a [`MpcController`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MpcSettings {
    /// The horizon.
    pub horizon: HorizonSettings,
    /// The observer.
    pub observer: ObserverSettings,
    /// The valves.
    pub valves: ValveModel,
}

/// Receding-horizon control of a joint, a millisecond at a time.
#[derive(Debug)]
pub struct MpcController<'a> {
    model: &'a JointModel<f64, AnyForce<f64>>,
    mass_kg: f64,
    settings: MpcSettings,
    horizon: Horizon<AnyBatch>,
    observer: Observer,
    modulators: [Modulator; 2],
    references: Vec<Reference>,
    flows_g_s: [f64; 2],
}

impl<'a> MpcController<'a> {
    /// A controller for a joint that is at rest, from a first reading.
    ///
    /// # Errors
    /// [`ControlError::Value`] if the settings are impossible.
    pub fn new(
        model: &'a JointModel<f64, AnyForce<f64>>,
        settings: MpcSettings,
        bounds: MassBounds,
        reading: &Reading,
    ) -> Result<Self, ControlError> {
        let h = &settings.horizon;
        ControlError::require_positive("steps of the horizon", h.steps as f64)?;
        for (field, value) in [
            ("step of the horizon (s)", h.step_s),
            ("weight of the displacement (mm)", h.displacement_mm),
            ("weight of the velocity (mm/s)", h.velocity_mm_s),
            ("weight of the air (g)", h.mass_g),
            ("weight of the flow (g/s)", h.flow_g_s),
            ("observer's pole (rad/s)", settings.observer.pole_rad_s),
            ("shortest opening (s)", settings.valves.shortest_s),
        ] {
            ControlError::require_positive(field, value)?;
        }
        Ok(Self {
            model,
            mass_kg: model.physical().mass_kg,
            settings,
            horizon: Horizon::new(model, AnyBatch::new(&model.force), settings.horizon, bounds),
            observer: Observer::at_rest(settings.observer, model, reading),
            modulators: [Modulator::default(); 2],
            references: vec![Reference::default(); settings.horizon.steps],
            flows_g_s: [0.0; 2],
        })
    }

    /// Estimated state of the joint.
    #[must_use]
    pub fn belief(&self) -> &Belief {
        self.observer.belief()
    }

    /// Takes a reading and says what the valves do next. `wanted` gives what is wanted so many seconds from
    /// now.
    pub fn tick(&mut self, reading: &Reading, wanted: impl Fn(f64) -> Reference) -> [Valve; 2] {
        let (batch, work) = self.horizon.force();
        self.observer.update(self.model, self.mass_kg, batch, work, reading, self.flows_g_s);
        for (k, reference) in self.references.iter_mut().enumerate() {
            *reference = wanted((k + 1) as f64 * self.settings.horizon.step_s);
        }
        let belief = *self.observer.belief();
        let valves = &self.settings.valves;
        let flows = self.horizon.solve(self.model, &belief, &self.references, valves);
        let pressures = self.model.gas_law_pressures_kpa(belief.displacement_mm, belief.masses);
        let mut openings = [Valve::Shut; 2];
        for i in 0..2 {
            (openings[i], self.flows_g_s[i]) =
                self.modulators[i].decide(flows[i], pressures[i], valves);
        }
        openings
    }
}

/// Motion of a joint under receding-horizon MPC, one value per sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MpcRun {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Wanted displacement, mm.
    pub wanted_mm: Vec<f64>,
    /// Measured displacement, mm.
    pub measured_mm: Vec<f64>,
    /// Force that the model does not explain, as believed, N.
    pub unexplained_n: Vec<f64>,
    /// Air in both muscles, as believed, g.
    pub masses_g: Vec<[f64; 2]>,
    /// Time that each decision took, s.
    pub decision_s: Vec<f64>,
}

impl MpcRun {
    /// Root mean square error of the displacement in a stretch of time, mm.
    #[must_use]
    pub fn rmse_mm(&self, [from_s, to_s]: [f64; 2]) -> f64 {
        let errors: Vec<f64> = (0..self.time_s.len())
            .filter(|&k| (from_s..to_s).contains(&self.time_s[k]))
            .map(|k| (self.wanted_mm[k] - self.measured_mm[k]).powi(2))
            .collect();
        (errors.iter().sum::<f64>() / errors.len().max(1) as f64).sqrt()
    }

    /// A quantile of the decisions' times, s.
    #[must_use]
    pub fn decision_quantile_s(&self, share: f64) -> f64 {
        quantile(&self.decision_s, share)
    }
}

/// A motion under receding-horizon control.
#[derive(Clone, Copy)]
pub struct MpcTask<'a> {
    /// Wanted motion.
    pub motion: &'a dyn Motion,
    /// How long it lasts, s.
    pub duration_s: f64,
    /// Air in both muscles (g) that holds the wanted stiffness at a time (s).
    pub total_g: &'a dyn Fn(f64) -> f64,
    /// Pressures to which the servo brings the muscles first, kPa absolute.
    pub first_kpa: [f64; 2],
    /// How long the servo takes for that, s.
    pub settle_s: f64,
    /// External force (N) at a time (s), unknown to the controller.
    pub force_n: &'a dyn Fn(f64) -> f64,
}

/// Lets the servo bring a joint to the first pressures, then controls it by receding-horizon MPC.
///
/// # Errors
/// As [`MpcController::new`], and [`ControlError::Insufficient`] if the joint or the estimate diverges.
pub fn run_mpc(
    joint: &mut impl Joint,
    model: &JointModel<f64, AnyForce<f64>>,
    settings: MpcSettings,
    bounds: MassBounds,
    task: &MpcTask<'_>,
) -> Result<MpcRun, ControlError> {
    let MpcTask { motion, total_g, force_n, .. } = task;
    let hold = JointCommand { force_n: 0.0, air: Air::Servo(task.first_kpa) };
    for _ in 0..(task.settle_s / SAMPLE_S).round() as usize {
        joint.tick(&hold);
    }
    // The valves stay shut for a moment, until the low-pass of the sensors has settled.
    let mut reading = joint.tick(&JointCommand { force_n: 0.0, air: Air::Sealed });
    for _ in 0..500 {
        reading = joint.tick(&JointCommand { force_n: 0.0, air: Air::Sealed });
    }
    let mut controller = MpcController::new(model, settings, bounds, &reading)?;
    let mut done = MpcRun::default();
    for k in 0..=(task.duration_s / SAMPLE_S).round() as usize {
        let time_s = k as f64 * SAMPLE_S;
        let start = Instant::now();
        let valves = controller.tick(&reading, |ahead_s| {
            let point = motion.at(time_s + ahead_s);
            Reference {
                displacement_mm: point.displacement_mm,
                velocity_mm_s: point.velocity_mm_s,
                total_g: total_g(time_s + ahead_s),
            }
        });
        done.decision_s.push(start.elapsed().as_secs_f64());
        done.time_s.push(time_s);
        done.wanted_mm.push(motion.at(time_s).displacement_mm);
        done.measured_mm.push(reading.displacement_mm);
        let belief = controller.belief();
        if !(belief.force_mn.is_finite() && reading.displacement_mm.is_finite()) {
            return Err(ControlError::Insufficient(format!(
                "the control diverges at t = {time_s:.3} s: the model's force or the joint's motion is not finite; the model is \
                 not of this joint"
            )));
        }
        done.unexplained_n.push(1e-3 * belief.force_mn);
        done.masses_g.push([belief.masses.flexor_g, belief.masses.extensor_g]);
        reading = joint.tick(&JointCommand { force_n: force_n(time_s), air: Air::Valves(valves) });
    }
    Ok(done)
}
