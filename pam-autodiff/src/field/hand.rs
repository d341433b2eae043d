//! Hand-written VJP and JVP of the joint with a network force.

use super::{At, Cotangent, DifferentiableField, Differentiation, Tangent};
use crate::batch::{BatchNetwork, NetworkBlock, NetworkSums};
use crate::numbers::Chunk;
use pam_core::joint::{ME, MF, PE, PF, V, X, pressure_rate};
use pam_core::{
    Chambers, JointField, MuscleGeometry, NetworkForce, ParametricField, ParametricForce, Scalar,
};
use std::borrow::Borrow;

/// Hand-written VJP and JVP of a [`JointField`] whose force is a network: the network by its batched
/// passes, one point at a time, the mechanics by formula, the gas by one dual evaluation with eight
/// derivatives.
///
/// A product from either side costs a few evaluations; nothing is allocated once the workspace is
/// there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ByHand;

/// A joint that [`ByHand`] differentiates.
#[derive(Debug, Clone)]
pub struct HandJoint<'a, F> {
    field: &'a JointField<f64, F>,
    network: BatchNetwork<f64>,
}

/// Memory for one point.
#[derive(Debug, Clone)]
pub struct HandWorkspace {
    bias: Vec<f64>,
    input: Vec<f64>,
    out: Vec<f64>,
    slopes: [f64; 4],
    block: NetworkBlock<f64>,
    sums: NetworkSums<f64>,
    /// Derivative of the force with respect to the network's parameters.
    by_parameter: Vec<f64>,
}

impl<F: Borrow<NetworkForce<f64>> + ParametricForce> Differentiation<JointField<f64, F>>
    for ByHand
{
    type Field<'a>
        = HandJoint<'a, F>
    where
        F: 'a;

    fn name(&self) -> &'static str {
        "hand"
    }

    fn of<'a>(&'a self, field: &'a JointField<f64, F>) -> HandJoint<'a, F> {
        HandJoint { field, network: BatchNetwork::new(field.force().borrow().mlp(), 0) }
    }
}

/// Number of variables of the pressure rates; their indices follow.
const GAS: usize = 8;
const GAS_X: usize = 0;
const GAS_V: usize = 1;
const GAS_C: usize = 2;
const GAS_NU: usize = 3;
const GAS_MASS: [usize; 2] = [4, 5];
const GAS_FLOW: [usize; 2] = [6, 7];

/// Places of the joint's own parameters after those of the network.
const RAW_MASS: usize = 0;
const RAW_C: usize = 1;
const RAW_NU: usize = 2;
const DAMPING: usize = 3;
const MASSES: usize = 4;

/// `[Ṗ_f, Ṗ_e]` of the numbers `[x, v, C, ν, m_f, m_e, ṁ_f, ṁ_e]`.
fn pressure_rates<S: Scalar>(geometry: &MuscleGeometry, z: &[S; GAS]) -> [S; 2] {
    let volumes = geometry.volumes(z[GAS_X], z[GAS_NU]);
    let rate = |i: usize, volume: S, slope: S| {
        pressure_rate(z[GAS_C], z[GAS_MASS[i]], z[GAS_FLOW[i]], volume, slope * z[GAS_V])
    };
    [
        rate(0, volumes.flexor_mm3, volumes.flexor_slope_mm2),
        rate(1, volumes.extensor_mm3, volumes.extensor_slope_mm2),
    ]
}

impl<F: ParametricForce> HandJoint<'_, F> {
    fn masses(&self, at: At<'_>) -> [f64; 2] {
        match self.field.chambers() {
            Chambers::Sealed(m) => [m.flexor_g, m.extensor_g],
            Chambers::OpenValves => [at.y[MF], at.y[ME]],
        }
    }

    fn is_sealed(&self) -> bool {
        matches!(self.field.chambers(), Chambers::Sealed(_))
    }

    fn gas_numbers(&self, at: At<'_>) -> [f64; GAS] {
        let [mf, me] = self.masses(at);
        let p = self.field.physical();
        let (ff, fe) = if self.is_sealed() { (0.0, 0.0) } else { (at.u[1], at.u[2]) };
        [at.y[X], at.y[V], p.gas_coefficient, p.deformation, mf, me, ff, fe]
    }

    /// The pressure rates with their derivatives.
    fn gas(&self, at: At<'_>) -> [Chunk<GAS>; 2] {
        let numbers = self.gas_numbers(at);
        let variables = std::array::from_fn(|i| Chunk::variable(numbers[i], i));
        pressure_rates(self.field.geometry(), &variables)
    }

    fn set_input(&self, at: At<'_>, work: &mut HandWorkspace) {
        let [mf, me] = self.masses(at);
        work.input[..4].copy_from_slice(&[mf, me, at.y[X], at.y[V]]);
    }

    /// The acceleration for a force of the network.
    fn acceleration(&self, at: At<'_>, force_mn: f64) -> f64 {
        let damping = self.field.auxiliary_damping_kg_s();
        (at.u[0] - force_mn - damping * at.y[V]) / self.field.physical().mass_kg
    }

    /// The network's force, its slopes along the inputs, and, if wanted, along its parameters.
    fn network(&self, at: At<'_>, parameters: bool, work: &mut HandWorkspace) -> f64 {
        self.set_input(at, work);
        let HandWorkspace { bias, input, out, slopes, block, sums, by_parameter } = work;
        let network = &self.network;
        network.forward_into(1, bias, input, out, &[], block);
        network.pull_back(1, &[1.0], slopes, &[], block);
        if parameters {
            network.accumulate(1, &[1.0], input, &[1.0], &[], sums, block);
            by_parameter.fill(0.0);
            network.drain_into(sums, &[], by_parameter, &mut []);
        }
        out[0]
    }

    /// `dC/draw` and so on: the slopes of the softplus.
    fn softplus_slopes(&self) -> [f64; 3] {
        let raw = self.field.raw();
        [raw.mass.sigmoid(), raw.gas_coefficient.sigmoid(), raw.deformation.sigmoid()]
    }
}

impl<F: ParametricForce> DifferentiableField for HandJoint<'_, F> {
    type Workspace = HandWorkspace;

    fn state_len(&self) -> usize {
        if self.is_sealed() { 4 } else { 6 }
    }

    fn input_len(&self) -> usize {
        if self.is_sealed() { 1 } else { 3 }
    }

    fn parameter_len(&self) -> usize {
        self.field.parameter_len()
    }

    fn workspace(&self) -> HandWorkspace {
        HandWorkspace {
            bias: self.network.fold(&[]),
            input: vec![0.0; self.network.input_stride()],
            out: vec![0.0; self.network.output_stride()],
            slopes: [0.0; 4],
            block: self.network.block(1),
            sums: self.network.sums(1),
            by_parameter: vec![0.0; self.network.parameter_len()],
        }
    }

    fn eval_into(&self, at: At<'_>, dy: &mut [f64], work: &mut HandWorkspace) {
        self.set_input(at, work);
        let HandWorkspace { bias, input, out, block, .. } = work;
        self.network.values_into(1, bias, input, out, &mut [], block);
        dy[X] = at.y[V];
        dy[V] = self.acceleration(at, out[0]);
        let rates = pressure_rates(self.field.geometry(), &self.gas_numbers(at));
        dy[PF..=PE].copy_from_slice(&rates);
        if !self.is_sealed() {
            dy[MF..=ME].copy_from_slice(&at.u[1..3]);
        }
    }

    fn vjp_into(&self, at: At<'_>, w: &[f64], sums: Cotangent<'_>, work: &mut HandWorkspace) {
        let mass = self.field.physical().mass_kg;
        let damping = self.field.auxiliary_damping_kg_s();
        let force = self.network(at, true, work);
        let by_force = w[V] / mass;
        let (network, own) = sums.p.split_at_mut(work.by_parameter.len());
        for (sum, slope) in network.iter_mut().zip(&work.by_parameter) {
            *sum -= by_force * slope;
        }
        let [slope_mf, slope_me, slope_x, slope_v] = work.slopes;
        sums.u[0] += by_force;
        sums.y[X] -= by_force * slope_x;
        sums.y[V] += w[X] - by_force * (slope_v + damping);
        let [mass_slope, c_slope, nu_slope] = self.softplus_slopes();
        own[RAW_MASS] -= by_force * self.acceleration(at, force) * mass_slope;
        own[DAMPING] -= by_force * at.y[V];

        let mut gas = [0.0; GAS];
        for (rate, w) in self.gas(at).iter().zip(&w[PF..=PE]) {
            for (sum, d) in gas.iter_mut().zip(rate.derivatives) {
                *sum += w * d;
            }
        }
        sums.y[X] += gas[GAS_X];
        sums.y[V] += gas[GAS_V];
        own[RAW_C] += gas[GAS_C] * c_slope;
        own[RAW_NU] += gas[GAS_NU] * nu_slope;
        let masses =
            [gas[GAS_MASS[0]] - by_force * slope_mf, gas[GAS_MASS[1]] - by_force * slope_me];
        if self.is_sealed() {
            own[MASSES] += masses[0];
            own[MASSES + 1] += masses[1];
        } else {
            sums.y[MF] += masses[0];
            sums.y[ME] += masses[1];
            sums.u[1] += gas[GAS_FLOW[0]] + w[MF];
            sums.u[2] += gas[GAS_FLOW[1]] + w[ME];
        }
    }

    fn jvp_into(&self, at: At<'_>, v: Tangent<'_>, dy: &mut [f64], work: &mut HandWorkspace) {
        let mass = self.field.physical().mass_kg;
        let damping = self.field.auxiliary_damping_kg_s();
        let (network, own) = v.p.split_at(work.by_parameter.len());
        let force = self.network(at, true, work);
        let [mass_slope, c_slope, nu_slope] = self.softplus_slopes();
        let masses =
            if self.is_sealed() { [own[MASSES], own[MASSES + 1]] } else { [v.y[MF], v.y[ME]] };
        let [slope_mf, slope_me, slope_x, slope_v] = work.slopes;
        let of_network: f64 = network.iter().zip(&work.by_parameter).map(|(p, s)| p * s).sum();
        let of_force = of_network
            + slope_mf * masses[0]
            + slope_me * masses[1]
            + slope_x * v.y[X]
            + slope_v * v.y[V];
        let resultant = v.u[0] - of_force - damping * v.y[V] - own[DAMPING] * at.y[V];
        dy[X] = v.y[V];
        dy[V] = (resultant - self.acceleration(at, force) * own[RAW_MASS] * mass_slope) / mass;
        let flows = if self.is_sealed() { [0.0; 2] } else { [v.u[1], v.u[2]] };
        let along = [
            v.y[X],
            v.y[V],
            own[RAW_C] * c_slope,
            own[RAW_NU] * nu_slope,
            masses[0],
            masses[1],
            flows[0],
            flows[1],
        ];
        for (rate, dy) in self.gas(at).iter().zip(&mut dy[PF..=PE]) {
            *dy = rate.derivatives.iter().zip(along).map(|(d, a)| d * a).sum();
        }
        if !self.is_sealed() {
            dy[MF..=ME].copy_from_slice(&flows);
        }
    }
}
