//! Effects that begin, end or grow at a time.
//!
//! [`timed`] makes of any effect, built-in or [expression](crate::expression), one that has further parameters: the times of its
//! [`ActivityWindow`]. Its share rises and falls by the smooth step `g = 3u² − 2u³`, `u = (t − onset)/ramp + ½` between 0 and 1, so
//! that the simulation is differentiable by the times as it is by any other parameter:
//!
//! | hook | with the share g |
//! |---|---|
//! | force, level of a dry friction, flow of air, inertia, delay of the drive | `g` times the effect's |
//! | command, sensors, readings at rest | `before + g (after − before)` |
//! | law of the chambers | factor, exponent, leaks: as the line above; beyond a limit a chamber follows with the share `1 − g` |
//! | memory | as at the beginning until the effect is there, then its own: `begin + g (advanced − begin)` in a step |
//!
//! Its id is that of the effect, and its definition the effect's: in files, the times stand beside the effect's own values.

use super::dynamic::{AnyEffect, EffectHooks, EffectScalar};
use super::{
    Absorbed, ChamberLaw, Command, DataScales, EffectInfo, FixedState, Group, Hooks, MemoryStart,
    Observed, Point, Rest,
};
use pam_core::units::ATMOSPHERE_KPA;
use pam_core::{AnyForce, JointModel, Scalar, smooth_step};
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::course::{ActivityWindow, LEAST_RAMP_S};
use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// An effect with a course in time.
pub struct Timed {
    inner: &'static dyn AnyEffect,
    course: ActivityWindow,
    info: &'static EffectInfo,
    /// Whether the effect changes inertia, delay of the drive or law of the chambers.
    changes_in_time: bool,
}

/// Timed effects by the address and the id of the effect and its course in time; the address distinguishes effects of one id.
type Known = HashMap<(usize, &'static str, ActivityWindow), &'static Timed>;

/// Every one that was made: effects are few, and a model is loaded often.
static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(Mutex::default);

/// The effect with a course; the effect itself where it is always there. A course replaces the one that the effect has.
#[must_use]
pub fn timed(effect: &'static dyn AnyEffect, course: ActivityWindow) -> &'static dyn AnyEffect {
    let effect = effect.course().map_or(effect, |timed| timed.inner);
    if course == ActivityWindow::ALWAYS {
        return effect;
    }
    let address = std::ptr::from_ref(effect).cast::<()>() as usize;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    *known
        .entry((address, effect.info().id, course))
        .or_insert_with(|| Box::leak(Box::new(Timed::new(effect, course))))
}

/// Starting times in the span of the data.
const STARTS: usize = 6;

/// Mean pressure at which it is asked whether there is dry friction, kPa.
const ANY_GAUGE_KPA: f64 = 300.0;

impl Timed {
    fn new(inner: &'static dyn AnyEffect, course: ActivityWindow) -> Self {
        let info = inner.info();
        let parameters: Vec<ParameterInfo> =
            info.parameters.iter().copied().chain(course.parameters()).collect();
        let own = inner.info();
        let info = EffectInfo { parameters: parameters.leak(), ..*info };
        // Asked at several values: where it is off, an effect changes nothing and has a derivative all the same.
        let of_range = |share: f64| {
            let at = |p: &ParameterInfo| p.range[0] + share * (p.range[1] - p.range[0]);
            own.parameters.iter().map(at).collect::<Vec<f64>>()
        };
        let all = |value: f64| vec![value; own.parameters.len()];
        let probes = [all(1.0), all(2.0), of_range(0.5), of_range(1.0)];
        let hooks = f64::hooks(inner);
        let changes = |probe: &Vec<f64>| {
            let values = [probe.as_slice(), &vec![0.0; own.switches.len()]].concat();
            hooks.inertia_kg(&values, 0.0) != 0.0 || hooks.delay_s(&values, 0.0) != 0.0
        };
        let changes_in_time = inner.changes_gas() || probes.iter().any(changes);
        Self { inner, course, info: Box::leak(Box::new(info)), changes_in_time }
    }

    /// The effect without a course.
    #[must_use]
    pub fn inner(&self) -> &'static dyn AnyEffect {
        self.inner
    }

    /// The times that it has.
    #[must_use]
    pub fn course(&self) -> ActivityWindow {
        self.course
    }

    /// Its own values, without the times.
    pub fn own_values<S: Copy>(&self, values: &[S]) -> Vec<S> {
        let (own, rest) = values.split_at(self.own_len());
        [own, &rest[self.course.time_len()..]].concat()
    }

    fn own_len(&self) -> usize {
        self.inner.info().parameters.len()
    }

    /// Calls the effect with its own values.
    #[inline]
    fn with_own<S: Copy, R>(&self, values: &[S], then: impl FnOnce(&[S]) -> R) -> R {
        if self.inner.info().switches.is_empty() {
            then(&values[..self.own_len()])
        } else {
            then(&self.own_values(values))
        }
    }

    /// The share of the effect that is there at a time (s since the excitation began).
    pub fn share<S: Scalar>(&self, values: &[S], time_s: S) -> S {
        let mut times = values[self.own_len()..].iter().copied();
        let mut next = |has: bool| if has { times.next() } else { None };
        let (onset, ramp, end) =
            (next(self.course.onset), next(self.course.ramp), next(self.course.end));
        let least = S::constant(LEAST_RAMP_S);
        let mut share = S::constant(1.0);
        if let Some(onset) = onset {
            share = smooth_step(time_s - onset, ramp.unwrap_or(least));
        }
        if let Some(end) = end {
            share *= smooth_step(end - time_s, least);
        }
        share
    }
}

/// Whether a share is that of an effect that is not there at all, or wholly.
fn is_none<S: Scalar>(share: S) -> bool {
    share.real() <= 0.0
}

fn is_whole<S: Scalar>(share: S) -> bool {
    share.real() >= 1.0
}

/// `before + share (after − before)`.
fn blend<S: Scalar>(share: S, before: S, after: S) -> S {
    before + share * (after - before)
}

impl<S: EffectScalar> EffectHooks<S> for Timed {
    fn begin(&self, p: &[S], at: &MemoryStart<S>, memory: &mut [S]) {
        self.with_own(p, |own| S::hooks(self.inner).begin(own, at, memory));
    }

    fn rest(&self, p: &[S], rest: &mut Rest<S>) {
        let share = self.share(p, S::constant(rest.start_s));
        if is_none(share) {
            return;
        }
        let before = *rest;
        self.with_own(p, |own| S::hooks(self.inner).rest(own, rest));
        if is_whole(share) {
            return;
        }
        let pair = |a: [S; 2], b: [S; 2]| [0, 1].map(|i| blend(share, a[i], b[i]));
        *rest = Rest {
            start_s: rest.start_s,
            start_force_mn: rest.start_force_mn,
            sealed_mm: blend(share, before.sealed_mm, rest.sealed_mm),
            sealed_kpa: pair(before.sealed_kpa, rest.sealed_kpa),
            start_mm: blend(share, before.start_mm, rest.start_mm),
            start_kpa: pair(before.start_kpa, rest.start_kpa),
        };
    }

    fn drive(&self, p: &[S], command: &Command<S>, memory: &mut [S]) -> S {
        let share = self.share(p, S::constant(command.time_s));
        // What the drive remembers goes on.
        let real = self.with_own(p, |own| S::hooks(self.inner).drive(own, command, memory));
        if is_none(share) {
            command.force_mn
        } else if is_whole(share) {
            real
        } else {
            blend(share, command.force_mn, real)
        }
    }

    fn delay_s(&self, p: &[S], time_s: f64) -> S {
        let share = self.share(p, S::constant(time_s));
        self.with_own(p, |own| S::hooks(self.inner).delay_s(own, time_s)) * share
    }

    fn force_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let share = self.share(p, at.time_s);
        if is_none(share) {
            return S::zero();
        }
        let force = self.with_own(p, |own| S::hooks(self.inner).force_mn(own, at, memory));
        if is_whole(share) { force } else { force * share }
    }

    fn dry_friction_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let share = self.share(p, at.time_s);
        if is_none(share) {
            return S::zero();
        }
        let level = self.with_own(p, |own| S::hooks(self.inner).dry_friction_mn(own, at, memory));
        if is_whole(share) { level } else { level * share }
    }

    fn air_g_s(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> [S; 2] {
        let share = self.share(p, at.time_s);
        if is_none(share) {
            return [S::zero(); 2];
        }
        let flow = self.with_own(p, |own| S::hooks(self.inner).air_g_s(own, at, memory));
        flow.map(|f| f * share)
    }

    fn share(&self, p: &[S], time_s: f64) -> f64 {
        Timed::share(self, p, S::constant(time_s)).real()
    }

    fn inertia_kg(&self, p: &[S], time_s: f64) -> S {
        let share = self.share(p, S::constant(time_s));
        self.with_own(p, |own| S::hooks(self.inner).inertia_kg(own, time_s)) * share
    }

    fn chamber(&self, p: &[S], time_s: f64, law: &mut ChamberLaw<S>) {
        let share = self.share(p, S::constant(time_s));
        if is_none(share) {
            return;
        }
        let before = *law;
        self.with_own(p, |own| S::hooks(self.inner).chamber(own, time_s, law));
        if is_whole(share) {
            return;
        }
        law.deformation_factor = blend(share, before.deformation_factor, law.deformation_factor);
        law.exponent = blend(share, before.exponent, law.exponent);
        for (leak, before) in law.leak_per_s.iter_mut().zip(before.leak_per_s) {
            *leak = blend(share, before, *leak);
        }
        if before.contraction_limit_mm.is_none() {
            law.beyond_limit = blend(share, S::constant(1.0), law.beyond_limit);
        }
    }

    fn advance(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]) {
        let hooks = S::hooks(self.inner);
        if memory.is_empty() || !self.inner.moves_with_the_joint() {
            return self.with_own(p, |own| hooks.advance(own, end, memory));
        }
        let share = self.share(p, end.time_s);
        let begun = |memory: &mut [S]| {
            memory.fill(S::zero());
            let at = MemoryStart {
                displacement_mm: end.displacement_mm,
                pressures_kpa: end.pressures_kpa(),
            };
            self.with_own(p, |own| hooks.begin(own, &at, memory));
        };
        if is_none(share) {
            return begun(memory);
        }
        self.with_own(p, |own| hooks.advance(own, end, memory));
        if !is_whole(share) {
            let advanced = memory.to_vec();
            begun(memory);
            for (m, advanced) in memory.iter_mut().zip(advanced) {
                *m = blend(share, *m, advanced);
            }
        }
    }

    fn observe(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let (start_s, step_s) = (seen.start_s, seen.step_s);
        let shares: Vec<S> = (0..seen.displacement_mm.len())
            .map(|k| self.share(p, S::constant(start_s + step_s * k as f64)))
            .collect();
        if shares.iter().all(|s| is_none(*s)) {
            return;
        }
        let [flexor, extensor] = &seen.pressures_kpa;
        let before = [&*seen.displacement_mm, &*seen.velocity_mm_s, &**flexor, &**extensor]
            .map(<[S]>::to_vec);
        self.with_own(p, |own| S::hooks(self.inner).observe(own, seen));
        let [flexor, extensor] = &mut seen.pressures_kpa;
        let after = [&mut *seen.displacement_mm, &mut *seen.velocity_mm_s, flexor, extensor];
        for (after, before) in after.into_iter().zip(before) {
            for ((after, before), &share) in after.iter_mut().zip(before).zip(&shares) {
                if !is_whole(share) {
                    *after = blend(share, before, *after);
                }
            }
        }
    }
}

impl AnyEffect for Timed {
    fn info(&self) -> &'static EffectInfo {
        self.info
    }

    fn definition(&self) -> Option<&'static str> {
        self.inner.definition()
    }

    fn course(&self) -> Option<&Timed> {
        Some(self)
    }

    fn changes_in_time(&self) -> bool {
        self.changes_in_time
    }

    fn may_stick_later(&self, values: &[f64]) -> bool {
        let joint = FixedState::at_rest([ATMOSPHERE_KPA + ANY_GAUGE_KPA; 2]);
        let memory = vec![0.0; self.inner.memory_len()];
        self.with_own(values, |own| {
            self.inner.may_stick_later(own)
                || f64::hooks(self.inner).dry_friction_mn(own, &joint.point(), &memory) > 0.0
        })
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let own = self.own_len();
        let at = |k: usize| scales.duration_s * (k as f64 + 0.5) / STARTS as f64;
        let times = |k: usize| -> Vec<f64> {
            let ramp = [LEAST_RAMP_S, 0.1 * scales.duration_s][usize::from(k % 2 == 1)];
            let end = at((k + STARTS / 2) % STARTS).max(at(k));
            let all = [
                (self.course.onset, at(k)),
                (self.course.ramp, ramp),
                (self.course.end, if self.course.onset { end } else { at(k) }),
            ];
            all.into_iter().filter_map(|(has, value)| has.then_some(value)).collect()
        };
        let inner = self.inner.starts(scales);
        let with = |start: &Vec<f64>| {
            let (parameters, switches) = start.split_at(own);
            (0..STARTS).map(|k| [parameters, &times(k), switches].concat()).collect::<Vec<_>>()
        };
        inner.iter().flat_map(with).collect()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        self.with_own(values, |own| self.inner.stands(own, scales))
    }

    fn acts_where_off(&self) -> bool {
        self.inner.acts_where_off()
    }

    fn changes_gas(&self) -> bool {
        self.inner.changes_gas()
    }

    fn hooks(&self) -> Hooks {
        self.inner.hooks()
    }

    fn memory_len(&self) -> usize {
        self.inner.memory_len()
    }

    fn remembers(&self) -> bool {
        self.inner.remembers()
    }

    fn moves_with_the_joint(&self) -> bool {
        self.inner.moves_with_the_joint()
    }

    fn absorb(&self, _values: &[f64], _joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        match self.info.group {
            Group::Sensing => Absorbed::OfInstruments,
            Group::Mechanics | Group::Gas => Absorbed::LeftOut,
        }
    }
}
