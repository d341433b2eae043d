//! The air of both chambers under a changed gas law.

use super::base::Base;
use crate::effects::ChamberLaw;
use pam_autodiff::Chunk;
use pam_core::units::ATMOSPHERE_KPA;
use pam_core::{MuscleGeometry, Scalar};

/// Volumes of flexor and extensor, with all derivatives in one pass.
#[inline]
fn volumes_mm3<S: Scalar>(geometry: &MuscleGeometry, x: &S, nu: &S) -> [S; 2] {
    let (displacement, deformation) = (x.real(), nu.real());
    let v = geometry.volumes(displacement, deformation);
    let [flexor, extensor] = geometry.volume_slopes_by_deformation(displacement, deformation);
    [
        S::with_slopes(v.flexor_mm3, [x, nu], [v.flexor_slope_mm2, flexor]),
        S::with_slopes(v.extensor_mm3, [x, nu], [v.extensor_slope_mm2, extensor]),
    ]
}

/// `c/V_s · (V_s/V)ⁿ`, with all derivatives in one pass.
#[inline]
fn polytropic<S: Scalar>(c: &S, n: &S, sealed: &S, volume: &S) -> S {
    let (exponent, sealed_mm3, mm3) = (n.real(), sealed.real(), volume.real());
    let isothermal = c.real() / mm3;
    if S::NDERIV == 0 && exponent == 1.0 {
        return S::constant(isothermal);
    }
    let by_ratio = (sealed_mm3 / mm3).ln();
    let value =
        if exponent == 1.0 { isothermal } else { isothermal * ((exponent - 1.0) * by_ratio).exp() };
    let slopes = [
        value / c.real(),
        value * by_ratio,
        value * (exponent - 1.0) / sealed_mm3,
        -value * exponent / mm3,
    ];
    S::with_slopes(value, [c, n, sealed, volume], slopes)
}

/// `a / b`.
#[inline]
fn ratio<S: Scalar>(a: &S, b: &S) -> S {
    let inverse = b.real().recip();
    let value = a.real() * inverse;
    S::with_slopes(value, [a, b], [inverse, -value * inverse])
}

/// Both chambers with their law.
#[derive(Debug, Clone, Copy)]
pub struct Chambers<'a, S> {
    base: &'a Base<S>,
    law: ChamberLaw<S>,
    /// Whether an effect changes the law; otherwise the plain law is computed, which costs less.
    changed: bool,
    sealed_mm3: [S; 2],
}

impl<S: Scalar> ChamberLaw<S> {
    /// The law of the base model.
    #[must_use]
    pub fn plain() -> Self {
        Self {
            deformation_factor: S::constant(1.0),
            exponent: S::constant(1.0),
            contraction_limit_mm: None,
            beyond_limit: S::zero(),
            leak_per_s: [S::zero(); 2],
            leaks: false,
            feeds_back: false,
        }
    }
}

impl<'a, S: Scalar> Chambers<'a, S> {
    /// Chambers that were sealed at displacement `sealed_mm`.
    #[must_use]
    pub fn new(base: &'a Base<S>, law: ChamberLaw<S>, changed: bool, sealed_mm: S) -> Self {
        let mut chambers = Self { base, law, changed, sealed_mm3: [S::constant(1.0); 2] };
        chambers.sealed_mm3 = chambers.volumes_mm3(sealed_mm);
        chambers
    }

    /// The volumes when they were sealed, mm³.
    #[must_use]
    pub(super) fn sealed_mm3(&self) -> [S; 2] {
        self.sealed_mm3
    }

    /// The same chambers under another law.
    #[must_use]
    pub(super) fn with_law(&self, law: ChamberLaw<S>, sealed_mm: S) -> Self {
        Self::new(self.base, law, self.changed, sealed_mm)
    }

    fn volumes_mm3(&self, x: S) -> [S; 2] {
        let nu = match self.changed {
            true => self.base.deformation * self.law.deformation_factor,
            false => self.base.deformation,
        };
        let geometry = &self.base.geometry;
        match self.law.contraction_limit_mm {
            None => volumes_mm3(geometry, &x, &nu),
            Some(limit) => {
                let beyond = |contraction: S| {
                    (contraction - limit).maximum(S::zero())
                        * (self.law.beyond_limit - S::constant(1.0))
                };
                [
                    geometry.volumes(x + beyond(x), nu).flexor_mm3,
                    geometry.volumes(x - beyond(-x), nu).extensor_mm3,
                ]
            }
        }
    }

    /// `C/V_s · (V_s/V(x))ⁿ`: pressure per mass at displacement `x`, kPa/g.
    pub fn pressures_per_mass(&self, x: S) -> [S; 2] {
        let volumes = self.volumes_mm3(x);
        let c = self.base.gas_coefficient;
        if !self.changed {
            return volumes.map(|v| ratio(&c, &v));
        }
        let n = &self.law.exponent;
        [0, 1].map(|i| polytropic(&c, n, &self.sealed_mm3[i], &volumes[i]))
    }

    /// Force on the joint (mN, towards +x) of the pressures by which this law differs from the base
    /// model's, `Σ ΔP_i dV_i/dx`, for masses in g.
    pub fn feedback_mn(&self, x: S, masses_g: [S; 2]) -> S {
        if !self.feeds_back() {
            return S::zero();
        }
        let (nu, c) = (self.base.deformation, self.base.gas_coefficient);
        let here = self.pressures_per_mass(x);
        // The volumes' slopes by two numbers alone, and the derivatives of all inputs in one pass.
        let v = self
            .base
            .geometry
            .volumes(Chunk::<2>::variable(x.real(), 0), Chunk::<2>::variable(nu.real(), 1));
        let chambers = [(v.flexor_mm3, v.flexor_slope_mm2), (v.extensor_mm3, v.extensor_slope_mm2)];
        let mut force = Chunk::<2>::constant(0.0);
        let (mut by_mass, mut by_pressure, mut by_c) = ([0.0; 2], [0.0; 2], 0.0);
        for (i, (volume, slope)) in chambers.into_iter().enumerate() {
            let per_volume = ratio(&Chunk::constant(1.0), &volume);
            let difference =
                (Chunk::constant(here[i].real()) - per_volume.scaled(c.real())) * slope;
            force += difference.scaled(masses_g[i].real());
            by_mass[i] = difference.value;
            by_pressure[i] = masses_g[i].real() * slope.value;
            by_c -= by_pressure[i] * per_volume.value;
        }
        let [by_x, by_nu] = force.derivatives;
        S::with_slopes(
            force.value,
            [&x, &nu, &c, &masses_g[0], &masses_g[1], &here[0], &here[1]],
            [by_x, by_nu, by_c, by_mass[0], by_mass[1], by_pressure[0], by_pressure[1]],
        )
    }

    /// Whether an effect changes the law, and pressures and their derivatives have no bend along the displacement.
    pub(super) fn is_changed_smoothly(&self) -> bool {
        self.changed && self.law.contraction_limit_mm.is_none()
    }

    /// Whether air is lost.
    #[must_use]
    pub fn leaks(&self) -> bool {
        self.changed && self.law.leaks
    }

    /// Whether the pressures push on the joint otherwise than in the base model.
    #[must_use]
    pub fn feeds_back(&self) -> bool {
        self.changed && self.law.feeds_back
    }

    /// Air after a step at displacement `x`, g.
    pub fn leaked(&self, x: S, step_s: f64, masses_g: [S; 2]) -> [S; 2] {
        let per_mass = self.pressures_per_mass(x);
        [0, 1].map(|i| {
            let excess = masses_g[i] - S::constant(ATMOSPHERE_KPA) / per_mass[i];
            masses_g[i] - (self.law.leak_per_s[i] * excess).scaled(step_s)
        })
    }
}
