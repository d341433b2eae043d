//! The rig: joint, pneumatics, sensors and hidden phenomena, one sample at a time.

use crate::effects::{Clock, Effect, Phenomenon, Seen, SetUp};
use crate::error::RigError;
use crate::plant::gas::ROOM_K;
use crate::plant::{Drive, Plant, PlantParameters, VolumeLaw};
use crate::pneumatics::{AirState, Opening, PneumaticsParameters, Servo, Supply, Valve};
use crate::sensors::{PressureSensor, SensorParameters};
use crate::truth::TruthRow;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_data::formats::raw_log::Row;
use pam_data::toml_file;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Parameters of a rig.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigParameters {
    /// Steps of the plant per sample.
    pub steps_per_sample: usize,
    /// The joint.
    pub plant: PlantParameters,
    /// Supply, valves, servo.
    pub pneumatics: PneumaticsParameters,
    /// Motor, sensors, clock.
    pub sensors: SensorParameters,
    /// Hidden effects, in the order in which they act.
    #[serde(rename = "effect")]
    pub effects: Vec<Effect>,
}

impl Default for RigParameters {
    fn default() -> Self {
        Self {
            steps_per_sample: 10,
            plant: PlantParameters::default(),
            pneumatics: PneumaticsParameters::default(),
            sensors: SensorParameters::default(),
            effects: Vec::new(),
        }
    }
}

impl RigParameters {
    /// Reads parameters from a TOML file; missing ones have their defaults.
    ///
    /// # Errors
    /// [`RigError`] naming file and line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, RigError> {
        Self::read_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn read_at(path: &Path) -> Result<Self, RigError> {
        Ok(toml_file::parse(&toml_file::text(path)?, path)?)
    }

    /// The parameters as TOML text.
    ///
    /// # Panics
    /// Never: every parameter can be written as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        pam_data::document::to_toml(self).expect("parameters are plain tables")
    }
}

/// Command to the valves during a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PressureCommand {
    /// All valves shut: the muscles are sealed.
    Sealed,
    /// The servo drives both muscles to these pressures, psi gauge.
    Servo([f64; 2]),
    /// The valves are driven directly.
    Valves([Opening; 2]),
}

/// Commands of the controller during a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Motor current that pushes along +x, A.
    pub current_a: f64,
    /// Valves.
    pub pressure: PressureCommand,
}

/// A sample: the row of the log and the ground truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The log's row.
    pub row: Row,
    /// The truth.
    pub truth: TruthRow,
}

impl Frame {
    /// True if all readings, position and velocity are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let Row { angle_deg, command, current_a, reservoir_psi, measured_psi: [f, e], .. } =
            self.row;
        let truth = [self.truth.displacement_mm, self.truth.velocity_mm_s];
        [angle_deg, command, current_a, reservoir_psi, f, e]
            .into_iter()
            .chain(truth)
            .all(f64::is_finite)
    }
}

/// A rig in operation.
///
/// ```
/// use pam_rig::{Command, PressureCommand, Rig, RigParameters};
///
/// let mut rig = Rig::new(&RigParameters::default(), 1, -4.0)?;
/// let inflate = Command { current_a: 0.0, pressure: PressureCommand::Servo([45.0, 45.0]) };
/// for _ in 0..4000 {
///     rig.tick(&inflate);
/// }
/// let push = Command { current_a: 1.0, pressure: PressureCommand::Sealed };
/// let frame = (0..500).map(|_| rig.tick(&push)).last().unwrap();
/// assert!(frame.truth.displacement_mm > 0.5);
/// # Ok::<(), pam_rig::RigError>(())
/// ```
pub struct Rig {
    sensors: SensorParameters,
    steps_per_sample: usize,
    plant: Plant,
    supply: Supply,
    valves: [Valve; 2],
    servos: [Servo; 2],
    pressure_sensors: [PressureSensor; 2],
    phenomena: Vec<Box<dyn Phenomenon>>,
    /// Shares of the phenomena in the set-up of the plant.
    shares: Vec<f64>,
    /// The set-up without phenomena.
    bare: SetUp,
    random: ChaCha8Rng,
    time_s: f64,
    sealed_g: Option<[f64; 2]>,
    target_psi: [f64; 2],
}

impl Rig {
    /// A rig at rest at room pressure. `start_s` is the time of its first sample; effects count their
    /// time from zero on, where excitations begin.
    ///
    /// # Errors
    /// [`RigError::Parameter`] if the parameters are impossible.
    pub fn new(parameters: &RigParameters, seed: u64, start_s: f64) -> Result<Self, RigError> {
        let phenomena: Vec<_> = parameters.effects.iter().map(Effect::start).collect();
        let bare = SetUp {
            plant: parameters.plant.clone(),
            laws: [VolumeLaw::default(); 2],
            frictions: Vec::new(),
        };
        // All of them at once must be possible, whenever each of them begins.
        let mut setup = bare.clone();
        for phenomenon in &phenomena {
            phenomenon.set_up(&mut setup);
        }
        crate::check::rig(parameters, &setup)?;
        let setup = bare.clone().with(&phenomena, start_s);
        let sensors = parameters.sensors;
        let sample_s = sensors.clock.sample_s();
        let step_s = sample_s / parameters.steps_per_sample as f64;
        let pneumatics = &parameters.pneumatics;
        Ok(Self {
            sensors,
            steps_per_sample: parameters.steps_per_sample,
            plant: Plant::new(&setup.plant, setup.laws, &setup.frictions),
            supply: Supply::new(pneumatics.supply),
            valves: [0, 1].map(|_| Valve::new(pneumatics.valve, step_s)),
            servos: [Servo::new(pneumatics.servo); 2],
            pressure_sensors: [PressureSensor::new(sensors.pressure, sample_s); 2],
            shares: shares(&phenomena, start_s),
            bare,
            phenomena,
            random: ChaCha8Rng::seed_from_u64(seed),
            time_s: start_s,
            sealed_g: None,
            target_psi: [0.0; 2],
        })
    }

    /// Time of the next sample, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The true state of the joint.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Fills the muscles at once instead of by the servo, to absolute pressures (kPa) at room
    /// temperature: a start without history.
    pub fn fill(&mut self, pressures_kpa: [f64; 2]) {
        self.plant.fill(pressures_kpa);
        self.target_psi = pressures_kpa.map(gauge_psi);
    }

    /// Reads all sensors, then carries the command out until the next sample.
    pub fn tick(&mut self, command: &Command) -> Frame {
        let sample_s = self.sensors.clock.sample_s();
        self.set_up();
        let [jitter, flexor, extensor, current]: [f64; 4] =
            std::array::from_fn(|_| self.random.sample(StandardNormal));
        let clock = |sealed_g| Clock { time_s: self.time_s, step_s: sample_s, sealed_g };
        let late_s = 1e-6 * self.sensors.clock.jitter_us * jitter;
        let mut seen = Seen {
            displacement_mm: self.plant.displacement_mm() + late_s * self.plant.velocity_mm_s(),
            pressures_kpa: self.plant.pressures_kpa(),
        };
        let clock = clock(self.sealed_g);
        for phenomenon in &mut self.phenomena {
            phenomenon.observe(&clock, &mut seen);
        }
        let [(raw_f, psi_f), (raw_e, psi_e)] = {
            let [a, b] = &mut self.pressure_sensors;
            let [f, e] = seen.pressures_kpa.map(gauge_psi);
            [a.read_psi(f, flexor), b.read_psi(e, extensor)]
        };

        let openings = self.openings(command, [raw_f, raw_e], 1e3 * sample_s);
        let flowing_a = self.sensors.motor.current_a(command.current_a);
        let row = Row {
            angle_deg: self.sensors.encoder.read_deg(seen.displacement_mm),
            command: self.sensors.motor.command(flowing_a),
            current_a: self.sensors.current.read_a(-flowing_a, current),
            reservoir_psi: gauge_psi(self.supply.pressure_kpa()),
            commanded_psi: self.target_psi,
            measured_psi: [psi_f, psi_e],
            valves: openings.map(valve_code),
            sync: true,
        };
        let mut truth = TruthRow::of(&self.plant);
        let (force_n, friction_n) = self.advance(flowing_a, openings);
        truth.force_n = force_n;
        truth.friction_n = friction_n;
        Frame { row, truth }
    }

    /// Changes the plant as phenomena come and go.
    fn set_up(&mut self) {
        let shares = shares(&self.phenomena, self.time_s);
        if shares != self.shares {
            let setup = self.bare.clone().with(&self.phenomena, self.time_s);
            self.plant.change(&setup.plant, setup.laws, &setup.frictions);
            self.shares = shares;
        }
    }

    /// Openings of the valves in this sample.
    fn openings(&mut self, command: &Command, raw_psi: [f64; 2], sample_ms: f64) -> [Opening; 2] {
        if let PressureCommand::Sealed = command.pressure {
            self.sealed_g.get_or_insert([0, 1].map(|i| self.plant.muscles()[i].air.mass_g));
        } else {
            self.sealed_g = None;
        }
        match command.pressure {
            PressureCommand::Servo(targets) => {
                self.target_psi = targets;
                [0, 1].map(|i| self.servos[i].decide(targets[i], raw_psi[i], sample_ms))
            }
            PressureCommand::Sealed => {
                self.servos.iter_mut().for_each(Servo::rest);
                [Opening::Shut; 2]
            }
            PressureCommand::Valves(openings) => {
                self.servos.iter_mut().for_each(Servo::rest);
                openings
            }
        }
    }

    /// Steps the plant through a sample; mean external force and mean dry friction, N.
    fn advance(&mut self, current_a: f64, openings: [Opening; 2]) -> (f64, f64) {
        let steps = self.steps_per_sample;
        let step_s = self.sensors.clock.sample_s() / steps as f64;
        let motor_n = self.sensors.motor.force_n(current_a);
        let start_s = self.time_s;
        let (mut force_sum, mut friction_sum) = (0.0, 0.0);
        for k in 0..steps {
            let clock =
                Clock { time_s: start_s + k as f64 * step_s, step_s, sealed_g: self.sealed_g };
            let mut drive = Drive { force_n: motor_n, ..Drive::default() };
            for phenomenon in &mut self.phenomena {
                drive.force_n = phenomenon.actuate(&clock, drive.force_n);
            }
            force_sum += drive.force_n;
            let mut taken_g = 0.0;
            for (i, opening) in openings.into_iter().enumerate() {
                let air = &self.plant.muscles()[i].air;
                let supply =
                    AirState { pressure_kpa: self.supply.pressure_kpa(), temperature_k: ROOM_K };
                let muscle = AirState {
                    pressure_kpa: air.pressure_kpa(),
                    temperature_k: air.temperature_k(),
                };
                let flow = self.valves[i].flow(opening, supply, muscle, ATMOSPHERE_KPA);
                drive.air_g[i] = flow.into_muscle_g_s * step_s;
                taken_g += flow.from_supply_g_s * step_s;
            }
            self.supply.give(taken_g, step_s);
            for phenomenon in &mut self.phenomena {
                drive.force_n += phenomenon.joint_force_n(&clock, &self.plant);
                drive.dry_friction_n += phenomenon.dry_friction_n(&clock, &self.plant);
                drive.muscle_scale *= phenomenon.muscle_scale(&clock);
                let [f, e] = phenomenon.air_g(&clock, &self.plant);
                drive.air_g[0] += f;
                drive.air_g[1] += e;
            }
            self.plant.step(step_s, &drive);
            friction_sum += self.plant.friction_n();
        }
        self.time_s = start_s + self.sensors.clock.sample_s();
        (force_sum / steps as f64, friction_sum / steps as f64)
    }
}

/// The shares of phenomena that are there at a time.
fn shares(phenomena: &[Box<dyn Phenomenon>], time_s: f64) -> Vec<f64> {
    phenomena.iter().map(|p| p.share(time_s)).collect()
}

/// Gauge pressure in psi.
fn gauge_psi(pressure_kpa: f64) -> f64 {
    (pressure_kpa - ATMOSPHERE_KPA) / KPA_PER_PSI
}

/// The valves of a muscle as a log writes them: −1 shut, 1 inflating, 2 exhausting.
fn valve_code(opening: Opening) -> i8 {
    match opening {
        Opening::Shut => -1,
        Opening::Inflate => 1,
        Opening::Exhaust => 2,
    }
}
