//! A phenomenon that comes or goes while the rig runs.
//!
//! The share of it that is there goes in a straight line from nothing to the whole over `ramp_s` about `onset_s` (at once where
//! no ramp is given), and is gone from `end_s` on. Forces, flows of air, levels of dry friction and changes of what the sensors
//! see act by that share. What a phenomenon changes in the set-up of the plant is changed by the share while the plant runs.
//! A phenomenon with memory in the balance of forces begins to remember when it begins to act.

use super::{Clock, Phenomenon, Seen, SetUp};
use crate::plant::{DryFriction, Plant};
use pam_vocabulary::course::{END, ONSET, RAMP};
use std::collections::BTreeMap;

/// The times of a phenomenon, s since the excitation began.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Times {
    onset_s: Option<f64>,
    ramp_s: Option<f64>,
    end_s: Option<f64>,
}

impl Times {
    /// The times among named values.
    pub(super) fn of(values: &BTreeMap<String, f64>) -> Self {
        let time = |name: &str| values.get(name).copied();
        Self { onset_s: time(ONSET.name), ramp_s: time(RAMP.name), end_s: time(END.name) }
    }

    /// Names and values, in the order of the vocabulary.
    pub(super) fn values(self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = [(ONSET.name, self.onset_s), (RAMP.name, self.ramp_s), (END.name, self.end_s)];
        all.into_iter().filter_map(|(name, value)| Some((name, value?)))
    }

    /// Whether there are none.
    pub(super) fn always(self) -> bool {
        self == Self::default()
    }

    /// The share at a time.
    fn share(self, time_s: f64) -> f64 {
        let begun = match (self.onset_s, self.ramp_s) {
            (None, _) => 1.0,
            (Some(onset), Some(ramp)) => ((time_s - onset) / ramp + 0.5).clamp(0.0, 1.0),
            // A time that is a sample belongs to what begins there.
            (Some(onset), None) => f64::from(u8::from(time_s >= onset - 1e-9)),
        };
        if self.end_s.is_some_and(|end| time_s >= end - 1e-9) { 0.0 } else { begun }
    }
}

/// A phenomenon with times.
pub(super) struct Timed {
    pub(super) inner: Box<dyn Phenomenon>,
    pub(super) times: Times,
}

impl Phenomenon for Timed {
    fn share(&self, time_s: f64) -> f64 {
        self.times.share(time_s)
    }

    fn set_up(&self, setup: &mut SetUp) {
        self.inner.set_up(setup);
    }

    fn actuate(&mut self, clock: &Clock, force_n: f64) -> f64 {
        // A delay line and a filter go on with what passes through them.
        let changed = self.inner.actuate(clock, force_n);
        force_n + self.share(clock.time_s) * (changed - force_n)
    }

    fn joint_force_n(&mut self, clock: &Clock, plant: &Plant) -> f64 {
        match self.share(clock.time_s) {
            0.0 => 0.0,
            share => share * self.inner.joint_force_n(clock, plant),
        }
    }

    fn dry_friction_n(&self, clock: &Clock, plant: &Plant) -> f64 {
        match self.share(clock.time_s) {
            0.0 => 0.0,
            share => share * self.inner.dry_friction_n(clock, plant),
        }
    }

    fn muscle_scale(&self, clock: &Clock) -> f64 {
        1.0 + self.share(clock.time_s) * (self.inner.muscle_scale(clock) - 1.0)
    }

    fn air_g(&mut self, clock: &Clock, plant: &Plant) -> [f64; 2] {
        let share = self.share(clock.time_s);
        if share == 0.0 {
            return [0.0; 2];
        }
        self.inner.air_g(clock, plant).map(|air| share * air)
    }

    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        let before = *seen;
        self.inner.observe(clock, seen);
        let share = self.share(clock.time_s);
        let between = |a: f64, b: f64| a + share * (b - a);
        seen.displacement_mm = between(before.displacement_mm, seen.displacement_mm);
        for (kpa, before) in seen.pressures_kpa.iter_mut().zip(before.pressures_kpa) {
            *kpa = between(before, *kpa);
        }
    }
}

impl SetUp {
    /// The set-up with the shares of some phenomena.
    pub(crate) fn with(mut self, phenomena: &[Box<dyn Phenomenon>], time_s: f64) -> Self {
        for phenomenon in phenomena {
            let share = phenomenon.share(time_s);
            if share == 0.0 {
                continue;
            }
            let before = self.clone();
            phenomenon.set_up(&mut self);
            if share < 1.0 {
                self.lessen(&before, share);
            }
        }
        self
    }

    /// Keeps a share of what was changed since `before`.
    fn lessen(&mut self, before: &Self, share: f64) {
        let between = |a: f64, b: f64| a + share * (b - a);
        let (plant, old) = (&mut self.plant, &before.plant);
        plant.mass_kg = between(old.mass_kg, plant.mass_kg);
        plant.viscous_ns_m = between(old.viscous_ns_m, plant.viscous_ns_m);
        for (leak, old) in plant.leak_per_s.iter_mut().zip(old.leak_per_s) {
            *leak = between(old, *leak);
        }
        for (law, old) in self.laws.iter_mut().zip(before.laws) {
            law.exponent = between(old.exponent, law.exponent);
            // A limit comes from infinitely far away.
            let reach = between(1.0 / old.largest_contraction_mm, 1.0 / law.largest_contraction_mm);
            law.largest_contraction_mm = 1.0 / reach;
        }
        for friction in &mut self.frictions[before.frictions.len()..] {
            let DryFriction { coulomb_n, static_n, velocity_mm_s } = *friction;
            *friction = DryFriction {
                coulomb_n: share * coulomb_n,
                static_n: share * static_n,
                velocity_mm_s,
            };
        }
    }
}
