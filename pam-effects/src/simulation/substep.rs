//! A step of the simulation, and what effects see in it.

use super::gas::Chambers;
use super::gas_table::GasTable;
use crate::effects::{Air, EffectScalar, StepStart};

/// A part of a step of the grid.
pub(super) struct Substep<S> {
    /// Time at which the grid's step starts, since the excitation began, s.
    pub(super) start_s: f64,
    /// Length of the grid's step, s.
    pub(super) grid_s: f64,
    /// Its ends, as shares of the grid's step.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Driving force at the start, the middle and the end of the grid's step, mN; a parabola between them.
    pub(super) driving_mn: [S; 3],
    /// The joint at its start.
    pub(super) start: StepStart<S>,
}

impl<S: EffectScalar> Substep<S> {
    /// The driving force at a share of the grid's step, mN.
    #[inline(always)]
    pub(super) fn driving_mn(&self, share: S) -> S {
        let [start, middle, end] = self.driving_mn;
        match share.real() {
            0.0 => start,
            0.5 => middle,
            1.0 => end,
            _ => {
                let slope = middle.scaled(4.0) - start.scaled(3.0) - end;
                let bend = (start + end - middle.scaled(2.0)).scaled(2.0);
                start + share * (slope + share * bend)
            }
        }
    }
}

/// The joint at a share of a step of the grid.
#[derive(Clone, Copy)]
pub(super) struct At<S> {
    /// Where a joint turns or breaks away, it has derivatives.
    pub(super) share: S,
    pub(super) x: S,
    pub(super) v: S,
}

/// The chambers with their air.
pub(super) struct SealedAir<'a, 'b, S> {
    pub(super) chambers: &'a Chambers<'b, S>,
    /// Their law as a table.
    pub(super) gas: Option<&'a GasTable<S>>,
    pub(super) air_g: &'a [S; 2],
}

impl<S: EffectScalar> Air<S> for SealedAir<'_, '_, S> {
    #[inline(always)]
    fn pressures_kpa(&self, displacement_mm: S) -> [S; 2] {
        let tabulated = self.gas.and_then(|gas| gas.pressures_per_mass(&displacement_mm));
        let per_mass =
            tabulated.unwrap_or_else(|| self.chambers.pressures_per_mass(displacement_mm));
        [self.air_g[0] * per_mass[0], self.air_g[1] * per_mass[1]]
    }

    fn masses_g(&self) -> [S; 2] {
        *self.air_g
    }
}
