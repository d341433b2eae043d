//! A recording on the simulation's own grid.

use super::input::{FineForce, interpolated, resampled};
use super::spectrum::MotionSpectrum;
use super::start::{StartVelocity, show_noise};
use super::steps::LONGEST_S;
use super::trial::range_of;
use crate::effects::{Before, Rest};
use pam_core::SealedMasses;
use pam_data::Subject;
use pam_data::preprocess::LowPass;
use pam_data::{Channel, MassOrigin, Recording};
use std::ops::Range;
use std::sync::Arc;

/// Where a trial came from.
#[derive(Debug, Clone)]
pub struct RecordSource {
    /// Name of the recording.
    pub name: String,
    /// Commanded gauge pressures, psi, if the name tells.
    pub command_psi: Option<[f64; 2]>,
    /// Where the masses came from.
    pub origin: MassOrigin,
    /// Time of the first sample, s.
    pub start_s: f64,
}

/// A recording on a uniform grid: what drives the joint, and what was measured.
///
/// Grid points are where simulated and measured channels meet; the simulation does one or more steps from
/// one to the next.
#[derive(Debug, Clone)]
pub struct ResampledRecord {
    /// Where it came from.
    pub source: RecordSource,
    /// Time between two grid points, s.
    pub step_s: f64,
    /// Steps of the simulation from one grid point to the next.
    pub steps_per_point: usize,
    /// Time between the start of the excitation and the first grid point, s; not zero for a part of a
    /// recording.
    pub since_start_s: f64,
    /// The motion before a part of a recording, which effects remember there.
    pub before: Option<Arc<Before>>,
    /// Time between two samples of the recording, s.
    pub sample_s: f64,
    /// The force at half steps of the simulation.
    pub force: FineForce,
    /// A part of this force that may be noise of its sensor, to which the joint did not respond; none unless
    /// [`Trial::with_doubtful_force`](super::Trial::with_doubtful_force) gives it.
    pub doubtful_force: Option<FineForce>,
    /// The low-pass that the measured channels went through, for the grid; simulated ones follow.
    pub low_pass: [Option<LowPass>; 4],
    /// Measured channels at the grid points, in the order of the state: mm, mm/s, kPa, kPa.
    pub measured: [Vec<f64>; 4],
    /// Steps of the sensors of the channels, in the same units; 0 where they are not known ([`Recording::resolution`]).
    ///
    /// [`Recording::resolution`]: pam_data::Recording::resolution
    pub resolution: [f64; 4],
    /// Readings at rest and at the first sample, as measured.
    pub rest: Rest<f64>,
    /// Velocity at the first sample.
    pub start_velocity: StartVelocity,
    /// Range of the displacement (mm) and of the velocity (mm/s) in which the joint moves.
    pub ranges: [[f64; 2]; 2],
    /// How fast the measured motion is; of a part of a recording that of the whole.
    pub(crate) spectrum: MotionSpectrum,
    /// Masses by the measured sealed pressures (or as given), g.
    pub masses: SealedMasses,
}

/// Times between samples above this keep their samples as grid points, s: shorter ones are averaged, two and
/// more to a point.
const SHORTEST_KEPT_S: f64 = 2.1e-3;
/// Largest relative difference of mean and median time between samples of a regular recording; a larger one is
/// a gap.
const REGULAR: f64 = 0.02;

/// A recording that is too long to be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{name}: the recording lasts {length_s:.3e} s, more than are simulated at once; is time_s in seconds? Cut it into \
     parts if it is"
)]
pub struct TooLong {
    /// Name of the recording.
    pub name: String,
    /// Its length, s.
    pub length_s: f64,
}

impl ResampledRecord {
    /// Most steps of a simulation: eleven hours of the longest ones.
    pub const MOST_STEPS: usize = 10_000_000;

    /// Longest step of the simulation, s; the distance of grid points where several samples are averaged.
    pub const STEP_S: f64 = LONGEST_S;

    /// Prepares a recording: force and channels on a grid for comparison. Recordings of more than 476 Hz are averaged to
    /// points of 4 ms, and slower ones have their own samples as grid points, with several steps of the simulation
    /// between two of them below 250 Hz.
    #[must_use]
    pub fn new(subject: &Subject) -> Self {
        let time_s = &subject.recording.time_s;
        let median_s = pam_data::recording::median_step_s(time_s);
        if median_s < SHORTEST_KEPT_S {
            return Self::dense(subject);
        }
        let (t0, t1) = subject.recording.span_s();
        let mean_s = (t1 - t0) / (time_s.len() - 1).max(1) as f64;
        let regular = (mean_s / median_s - 1.0).abs() < REGULAR;
        let step_s = if regular { mean_s } else { median_s };
        // Times are rounded when they are stored: 4.0001 ms are one step.
        let steps = (step_s / LONGEST_S - 1e-3).ceil().max(1.0) as usize;
        Self::on_grid(subject, step_s, steps)
    }

    /// Prepares a recording with a grid point at every step of the simulation, 4 ms apart, for predictions
    /// at any time.
    #[must_use]
    pub fn dense(subject: &Subject) -> Self {
        Self::on_grid(subject, LONGEST_S, 1)
    }

    /// Checks that a recording is not too long to be simulated.
    ///
    /// # Errors
    /// [`TooLong`] for more than [`MOST_STEPS`](Self::MOST_STEPS) steps of the simulation, as of recordings whose times
    /// are not in seconds.
    pub fn check(subject: &Subject) -> Result<(), TooLong> {
        let (t0, t1) = subject.recording.span_s();
        if t1 - t0 <= Self::MOST_STEPS as f64 * LONGEST_S {
            return Ok(());
        }
        Err(TooLong { name: subject.recording.name.clone(), length_s: t1 - t0 })
    }

    /// The grid; of a recording that [`check`](Self::check) refuses its beginning.
    fn on_grid(subject: &Subject, step_s: f64, steps_per_point: usize) -> Self {
        let r = &subject.recording;
        let (t0, t1) = r.span_s();
        let steps_per_point = steps_per_point.min(Self::MOST_STEPS / 2);
        let t1 = t1.min(t0 + (Self::MOST_STEPS / steps_per_point) as f64 * step_s);
        let points = (((t1 - t0) / step_s + 1e-6).floor() as usize + 1).max(2);
        let sample_s = pam_data::recording::median_step_s(&r.time_s);
        let averaged = sample_s < SHORTEST_KEPT_S;
        let measured = Channel::ALL.map(|c| {
            if averaged {
                resampled(&r.time_s, r.channel(c), sample_s, t0, step_s, points)
            } else {
                interpolated(&r.time_s, r.channel(c), t0, step_s, points)
            }
        });
        let sealed = r.reading_at_rest();
        let [x0, _, pf0, pe0] = r.initial_state();
        let resolution = r.resolution();
        let force = fine_force(r, step_s, steps_per_point, points);
        let rest = Rest {
            start_s: 0.0,
            start_force_mn: force.values_mn()[0],
            sealed_mm: sealed.displacement_mm,
            sealed_kpa: [sealed.pressure_flexor_kpa, sealed.pressure_extensor_kpa],
            start_mm: x0,
            start_kpa: [pf0, pe0],
        };
        Self {
            source: RecordSource {
                name: r.name.clone(),
                command_psi: r.command_psi,
                origin: subject.origin,
                start_s: t0,
            },
            step_s,
            steps_per_point,
            since_start_s: 0.0,
            before: None,
            sample_s,
            force,
            doubtful_force: None,
            low_pass: r.low_passed.cutoff_hz.map(|cutoff| {
                cutoff.and_then(|hz| LowPass::like(hz, 1.0 / sample_s, 1.0 / step_s))
            }),
            ranges: [range_of(&measured[0]), range_of(&measured[1])],
            spectrum: MotionSpectrum::new(&measured[0], step_s, sample_s),
            measured,
            start_velocity: StartVelocity::of(r, resolution[1]),
            resolution,
            rest,
            masses: subject.masses,
        }
    }

    /// The same recording, in which the force of another one of the same times is the part of the force that may be noise.
    #[must_use]
    pub(super) fn with_doubtful_force(self, recording: &Recording) -> Self {
        let force = fine_force(recording, self.step_s, self.steps_per_point, self.points());
        Self { doubtful_force: Some(force), ..self }
    }

    /// Grid points of this range as a recording of their own, which starts from the measured state at the first of them. Masses
    /// and readings at rest are those of the whole, and times still count from the start of the excitation. What effects on the
    /// joint and its air remember there follows from the motion that was measured before.
    ///
    /// # Panics
    /// If the range is empty or longer than the recording.
    #[must_use]
    pub fn part(&self, points: Range<usize>) -> Self {
        let first = points.start;
        let start_s = self.step_s * first as f64;
        let [x, flexor, extensor] = [0, 2, 3].map(|c| self.measured[c][first]);
        Self {
            source: RecordSource { start_s: self.source.start_s + start_s, ..self.source.clone() },
            since_start_s: self.since_start_s + start_s,
            before: self.measured_before(first).map(Arc::new),
            start_velocity: StartVelocity::at(self, first),
            rest: Rest {
                start_s: self.since_start_s + start_s,
                start_force_mn: self.force_mn(first),
                start_mm: x,
                start_kpa: [flexor, extensor],
                ..self.rest
            },
            ..self.slice(points)
        }
    }

    /// The first grid points as a recording.
    ///
    /// # Panics
    /// If there are none, or more than the recording has.
    #[must_use]
    pub fn until(&self, points: usize) -> Self {
        self.slice(0..points)
    }

    /// Force and measured channels at grid points of this range, and everything else as it is.
    fn slice(&self, points: Range<usize>) -> Self {
        let halves = 2 * self.steps_per_point;
        let forces = halves * points.start..halves * points.end;
        Self {
            force: self.force.part(forces.clone()),
            doubtful_force: self.doubtful_force.as_ref().map(|f| f.part(forces)),
            measured: self.measured.each_ref().map(|channel| channel[points.clone()].to_vec()),
            ..self.clone()
        }
    }

    /// Whether differences between neighbouring grid points show noise and not motion.
    #[must_use]
    pub fn shows_noise(&self) -> bool {
        show_noise(self.step_s)
    }

    /// Number of grid points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.measured[0].len()
    }

    /// Number of grid points within this time of the first one, s.
    #[must_use]
    pub fn points_within(&self, length_s: f64) -> usize {
        self.points().min((length_s / self.step_s) as usize)
    }

    /// Number of grid points to be simulated so that those before `until` are what they are in the whole recording: the
    /// low-pass looks ahead.
    #[must_use]
    pub fn points_for(&self, until: usize) -> usize {
        let ahead = self.filters().iter().flatten().map(LowPass::memory).max().unwrap_or(0);
        until
            .saturating_add(ahead)
            .clamp(LowPass::shortest(), self.points().max(LowPass::shortest()))
            .min(self.points())
    }

    /// Number of steps of the simulation.
    #[must_use]
    pub fn steps(&self) -> usize {
        (self.points() - 1) * self.steps_per_point
    }

    /// Length of a step of the simulation, s.
    #[must_use]
    pub fn fine_step_s(&self) -> f64 {
        self.step_s / self.steps_per_point as f64
    }

    /// The recorded force at a grid point, mN.
    #[must_use]
    pub fn force_mn(&self, point: usize) -> f64 {
        self.force.values_mn()[2 * self.steps_per_point * point]
    }

    /// Displacements (mm) and velocities (mm/s) that span the motion.
    pub(super) fn operating_points(&self) -> impl Iterator<Item = [f64; 2]> {
        let [x, v] = self.ranges.map(|[low, high]| [low, 0.5 * (low + high), high]);
        x.into_iter().flat_map(move |x| v.map(|v| [x, v]))
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.step_s * (self.points() - 1) as f64
    }

    /// The filters that simulated channels go through; none where there are too few points to filter.
    #[must_use]
    pub fn filters(&self) -> [Option<LowPass>; 4] {
        self.low_pass.map(|filter| filter.filter(|_| self.points() >= LowPass::shortest()))
    }
}

/// The force of a recording at half steps of the simulation.
fn fine_force(r: &Recording, step_s: f64, steps_per_point: usize, points: usize) -> FineForce {
    let half_s = 0.5 * step_s / steps_per_point as f64;
    FineForce::new(r, half_s, 2 * points * steps_per_point)
}
