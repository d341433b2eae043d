//! Values that expressions read in a simulation of the joint.

use crate::effects::Point;
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_expression::Inputs;
use std::cell::OnceCell;

/// Indices of the variables, in the order of [`Language::joint`](pam_vocabulary::definition::Language::joint).
pub(super) const X: usize = 0;
pub(super) const V: usize = 1;
pub(super) const PF: usize = 2;
pub(super) const PE: usize = 3;
const MF: usize = 4;
const ME: usize = 5;
pub(super) const FORCE: usize = 6;
pub(super) const NETWORK: usize = 7;
pub(super) const T: usize = 8;
pub(super) const DT: usize = 9;
pub(super) const DX: usize = 10;
pub(super) const X0: usize = 11;
/// Number of the variables.
pub(super) const VARIABLES: usize = 12;

/// The joint at an instant, with the values of the effect and what it remembers.
pub(super) struct Instant<'a, S> {
    pub(super) at: &'a Point<'a, S>,
    pub(super) p: &'a [S],
    pub(super) memory: &'a [S],
    /// Whether the start of the step is meant, not the instant.
    pub(super) at_start: bool,
    pressures_kpa: OnceCell<[S; 2]>,
}

impl<'a, S: Scalar> Instant<'a, S> {
    pub(super) fn new(at: &'a Point<'a, S>, p: &'a [S], memory: &'a [S]) -> Self {
        Self { at, p, memory, at_start: false, pressures_kpa: OnceCell::new() }
    }

    pub(super) fn at_start(at: &'a Point<'a, S>, p: &'a [S], memory: &'a [S]) -> Self {
        Self { at_start: true, ..Self::new(at, p, memory) }
    }

    fn x(&self) -> &S {
        if self.at_start { &self.at.step_start.displacement_mm } else { &self.at.displacement_mm }
    }

    fn v(&self) -> &S {
        if self.at_start { &self.at.step_start.velocity_mm_s } else { &self.at.velocity_mm_s }
    }

    #[inline(never)]
    fn pressures_kpa(&self) -> &[S; 2] {
        self.pressures_kpa.get_or_init(|| self.at.air.pressures_kpa(*self.x()))
    }

    /// An input that is kept as it is read; the others are worked out.
    #[inline(always)]
    fn kept(&self, index: usize) -> Option<&S> {
        Some(match index {
            X => self.x(),
            V => self.v(),
            PF => &self.pressures_kpa()[0],
            PE => &self.pressures_kpa()[1],
            X0 => &self.at.step_start.displacement_mm,
            k if k < VARIABLES => return None,
            k if k < VARIABLES + self.p.len() => &self.p[k - VARIABLES],
            k => &self.memory[k - VARIABLES - self.p.len()],
        })
    }
}

impl<S: Scalar> Inputs<S> for Instant<'_, S> {
    // In the loop of a program, a call for each number would take as long as an instruction.
    #[inline(always)]
    fn input(&self, index: usize) -> S {
        if let Some(kept) = self.kept(index) {
            return *kept;
        }
        let at = self.at;
        match index {
            MF => at.air.masses_g()[0],
            ME => at.air.masses_g()[1],
            FORCE if self.at_start => at.step_start.driving_mn.scaled(1.0 / MN_PER_N),
            FORCE => at.driving_mn.scaled(1.0 / MN_PER_N),
            NETWORK if self.at_start => self.network_n(*self.x(), *self.v()),
            NETWORK => at.restoring_mn().scaled(1.0 / MN_PER_N),
            T if self.at_start => S::constant(at.time_s.real() - at.since_step_s),
            T => at.time_s,
            DT => S::constant(at.since_step_s),
            // The last of those that are worked out.
            _ => at.displacement_mm - at.step_start.displacement_mm,
        }
    }

    // A number with many derivatives is not copied for one of its parts.
    #[inline(always)]
    fn real(&self, index: usize) -> f64 {
        match self.kept(index) {
            Some(kept) => kept.real(),
            None => self.input(index).real(),
        }
    }

    #[inline(always)]
    fn add_along(&self, index: usize, slope: f64, to: &mut S) {
        match self.kept(index) {
            Some(kept) => to.add_along(kept, slope),
            None => to.add_along(&self.input(index), slope),
        }
    }

    fn network_n(&self, x: S, v: S) -> S {
        self.at.base.restoring_mn(x, v).scaled(1.0 / MN_PER_N)
    }
}

/// Variables in a row, the values of the effect, and what it remembers.
pub(super) struct Row<'a, S> {
    pub(super) variables: &'a [S; VARIABLES],
    pub(super) p: &'a [S],
    pub(super) memory: &'a [S],
}

impl<S: Scalar> Row<'_, S> {
    #[inline(always)]
    fn at(&self, index: usize) -> &S {
        match index {
            k if k < VARIABLES => &self.variables[k],
            k if k < VARIABLES + self.p.len() => &self.p[k - VARIABLES],
            k => &self.memory[k - VARIABLES - self.p.len()],
        }
    }
}

impl<S: Scalar> Inputs<S> for Row<'_, S> {
    // In the loop of a program, a call for each number would take as long as an instruction.
    #[inline(always)]
    fn input(&self, index: usize) -> S {
        *self.at(index)
    }

    #[inline(always)]
    fn real(&self, index: usize) -> f64 {
        self.at(index).real()
    }

    #[inline(always)]
    fn add_along(&self, index: usize, slope: f64, to: &mut S) {
        to.add_along(self.at(index), slope);
    }
}
