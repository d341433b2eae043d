//! Networks of any shape: exact solutions and gradients against Runge–Kutta steps that land on every kink,
//! and affine pieces against the network itself.

use crate::common;
use crate::common::limits::{distance_from_discrete_adjoint, largest_difference_mm};
use crate::common::random::random_joint;
use pam_core::Activation;
use pam_exact::{Partition, Plane, Window};
use pam_solvers::Interpolation;

/// Widths that are no multiples of a vector's, one layer and several.
const SHAPES: [&[usize]; 5] =
    [&[37], &[44, 29], &[19, 50, 21], &[12, 28, 20, 33], &[7, 3, 30, 2, 11]];

fn joints() -> impl Iterator<Item = (String, common::Joint)> {
    let leaky = *common::published().force.mlp().activation();
    let relu = Activation::from_name("relu").unwrap();
    SHAPES.into_iter().flat_map(move |shape| {
        [(leaky, "leaky"), (relu, "relu")].map(|(activation, name)| {
            (format!("{shape:?} {name}"), random_joint(shape, activation))
        })
    })
}

#[test]
fn solutions_are_those_of_steps_that_land_on_kinks() {
    let (times, force) = common::excitation(38.0, 3000);
    let masses = common::masses(3)[2];
    let mut crossings = 0;
    for (name, model) in joints() {
        let signal = (&times[..], &force[..]);
        let (off, counts) =
            largest_difference_mm(&model, signal, Interpolation::Hold, masses, 2.5e-4);
        assert!(off < 1e-10, "{name}: {off:e} mm, {counts:?}");
        crossings += counts.crossings;
    }
    assert!(crossings > 500, "only {crossings} crossings");
}

#[test]
fn gradients_are_the_limit_of_discrete_adjoints() {
    for (name, model) in joints() {
        let [off, step] =
            distance_from_discrete_adjoint(&model, 2, 38.0, 600, Interpolation::Linear, 5e-4);
        assert!(off < 1e-8 && step < 1e-6, "{name}: {off:e} {step:e}");
    }
}

#[test]
fn polygons_are_pieces_of_the_network() {
    let masses = common::masses(3)[2];
    let masses_g = [masses.flexor_g, masses.extensor_g];
    let window = Window { first: [-3.0, 3.0], second: [-40.0, 40.0] };
    for (name, model) in joints() {
        let network = common::motion(&model).network;
        let partition = Partition::new(&network, Plane::of_motion(masses_g), window, 100_000);
        assert!(partition.uncovered_share.abs() < 1e-12, "{name}: {:e}", partition.uncovered_share);
        for polygon in &partition.regions {
            let corners = polygon.vertices.len() as f64;
            let middle =
                [0, 1].map(|i| polygon.vertices.iter().map(|c| c[i]).sum::<f64>() / corners);
            let force = network.force_mn([masses_g[0], masses_g[1], middle[0], middle[1]]);
            let off = (force - polygon.force_mn(middle)).abs();
            // Relative to the terms whose difference is the force.
            assert!(off < 1e-12 * 1.6e8, "{name}: {force}, off by {off:e}");
        }
    }
}
