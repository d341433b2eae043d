//! Every differentiation of a field against the others, against differences, and against itself.

use pam_autodiff::{
    At, ByChunk, ByDual, ByHand, ByTape, Cotangent, DifferentiableField, Differentiation, Tangent,
};
use pam_core::{Activation, JointField, NetworkForce, ParametricField, VectorField};
use proptest::prelude::*;

use crate::support::{joint, network, operating_point, spring};

/// `Jᵀ w` with respect to state, input and parameters, one after the other.
fn vjp<D: Differentiation<F>, F: ParametricField>(
    differentiation: &D,
    field: &F,
    at: At<'_>,
    w: &[f64],
) -> Vec<f64> {
    let field = differentiation.of(field);
    let mut work = field.workspace();
    let (mut y, mut u) = (vec![0.0; field.state_len()], vec![0.0; field.input_len()]);
    let mut p = vec![0.0; field.parameter_len()];
    // The second product is one in a used workspace.
    for _ in 0..2 {
        for sum in [&mut y, &mut u, &mut p] {
            sum.fill(0.0);
        }
        let sums = Cotangent { y: &mut y, u: &mut u, p: &mut p };
        field.vjp_into(at, w, sums, &mut work);
    }
    [y, u, p].concat()
}

/// `J v` for a direction of state, input and parameters, one after the other.
fn jvp<D: Differentiation<F>, F: ParametricField>(
    differentiation: &D,
    field: &F,
    at: At<'_>,
    v: &[f64],
) -> Vec<f64> {
    let field = differentiation.of(field);
    let mut work = field.workspace();
    let (y, rest) = v.split_at(field.state_len());
    let (u, p) = rest.split_at(field.input_len());
    let mut dy = vec![0.0; field.state_len()];
    for _ in 0..2 {
        field.jvp_into(at, Tangent { y, u, p }, &mut dy, &mut work);
    }
    dy
}

/// `J v` by a central difference of the field itself.
fn difference<F: ParametricField>(field: &F, at: At<'_>, v: &[f64], h: f64) -> Vec<f64> {
    let p = field.parameters();
    let value = |h: f64| {
        let mut moved = at.y.iter().chain(at.u).chain(&p).zip(v).map(|(x, d)| x + h * d);
        let y: Vec<f64> = moved.by_ref().take(at.y.len()).collect();
        let u: Vec<f64> = moved.by_ref().take(at.u.len()).collect();
        let p: Vec<f64> = moved.collect();
        let field = field.with_parameters(&p);
        let mut dy = vec![0.0; y.len()];
        field.eval_into(at.t, &y, &u, &mut dy, &mut vec![0.0; field.work_len()]);
        dy
    };
    value(h).iter().zip(value(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A direction in which every argument moves by its own size.
fn direction<F: ParametricField>(field: &F, at: At<'_>, seed: f64) -> Vec<f64> {
    let p = field.parameters();
    let all = at.y.iter().chain(at.u).chain(&p);
    all.enumerate().map(|(k, x)| (seed + k as f64 * 0.77).sin() * (x.abs() + 1e-3)).collect()
}

fn assert_close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    assert_eq!(a.len(), b.len());
    for (k, (x, y)) in a.iter().zip(b).enumerate() {
        assert!((x - y).abs() <= tolerance * (1e-9 + x.abs().max(y.abs())), "{what} {k}: {x} {y}");
    }
}

fn all_agree<F: ParametricField>(field: &F, sealed: bool, what: &str) {
    let (y, u) = operating_point(sealed);
    let at = At { t: 0.3, y: &y, u: &u };
    let v = direction(field, at, 0.4);
    let by_tape = jvp(&ByTape, field, at, &v);
    assert_close(&by_tape, &jvp(&ByDual, field, at, &v), 1e-11, what);
    assert_close(&by_tape, &difference(field, at, &v, 1e-6), 1e-6, what);
    let w: Vec<f64> = (0..y.len()).map(|k| 1.0 / (1.0 + k as f64)).collect();
    let by_tape = vjp(&ByTape, field, at, &w);
    assert_close(&by_tape, &vjp(&ByDual, field, at, &w), 1e-10, what);
    assert_close(&by_tape, &vjp(&ByChunk::<3>, field, at, &w), 1e-10, what);
}

/// The hand-written products against the tape's.
fn by_hand_agrees(field: &JointField<f64, NetworkForce<f64>>, sealed: bool, what: &str) {
    let (y, u) = operating_point(sealed);
    let at = At { t: 0.3, y: &y, u: &u };
    let v = direction(field, at, 0.4);
    assert_close(&jvp(&ByHand, field, at, &v), &jvp(&ByTape, field, at, &v), 1e-11, what);
    let w: Vec<f64> = (0..y.len()).map(|k| 1.0 / (1.0 + k as f64)).collect();
    assert_close(&vjp(&ByHand, field, at, &w), &vjp(&ByTape, field, at, &w), 1e-10, what);
    let by_hand = ByHand.of(field);
    let (mut dy, mut plain) = (vec![0.0; y.len()], vec![0.0; y.len()]);
    by_hand.eval_into(at, &mut dy, &mut by_hand.workspace());
    field.eval_into(at.t, &y, &u, &mut plain, &mut vec![0.0; field.work_len()]);
    assert_close(&dy, &plain, 1e-12, what);
}

#[test]
fn tape_dual_and_difference_agree_for_every_activation() {
    for name in Activation::NAMES {
        for sealed in [true, false] {
            let field = joint(network(name, &[7, 5]), sealed);
            let what = format!("{name}, sealed {sealed}");
            all_agree(&field, sealed, &what);
            by_hand_agrees(&field, sealed, &what);
        }
    }
    for sealed in [true, false] {
        all_agree(&joint(spring(), sealed), sealed, "spring");
    }
}

/// The parameters of mass, gas and deformation act through a softplus that is recorded before the
/// mark; the slope of the acceleration with respect to the raw mass is −a/m · σ(raw).
#[test]
fn derived_parameters_get_their_cotangents() {
    let field = joint(spring(), true);
    let (y, u) = operating_point(true);
    let gradient = vjp(&ByTape, &field, At { t: 0.0, y: &y, u: &u }, &[0.0, 1.0, 0.0, 0.0]);
    let mut dy = [0.0; 4];
    field.eval_into(0.0, &y, &u, &mut dy, &mut []);
    let raw = field.raw().mass;
    let expected = -dy[1] / field.physical().mass_kg / (1.0 + (-raw).exp());
    let at_raw_mass = gradient[4 + 1 + 4];
    assert!((at_raw_mass - expected).abs() < 1e-13 * expected.abs(), "{at_raw_mass} {expected}");
}

#[test]
fn evaluations_are_plain_ones() {
    let field = joint(network("tanh", &[9]), true);
    let (y, u) = operating_point(true);
    let at = At { t: 0.0, y: &y, u: &u };
    let (mut plain, mut taped, mut dual) = ([0.0; 4], [0.0; 4], [0.0; 4]);
    field.eval_into(0.0, &y, &u, &mut plain, &mut vec![0.0; VectorField::work_len(&field)]);
    let by_tape = ByTape.of(&field);
    by_tape.eval_into(at, &mut taped, &mut by_tape.workspace());
    let by_dual = ByDual.of(&field);
    by_dual.eval_into(at, &mut dual, &mut by_dual.workspace());
    assert_eq!((plain, plain), (taped, dual));
}

/// `⟨w, J v⟩ = ⟨Jᵀ w, v⟩`.
fn identity<D: Differentiation<JointField<f64, F>>, F>(
    differentiation: &D,
    field: &JointField<f64, F>,
    (y, u): (&[f64], &[f64]),
    (w, v): (&[f64], &[f64]),
) -> Result<(), TestCaseError>
where
    JointField<f64, F>: ParametricField,
{
    let at = At { t: 0.0, y, u };
    // State and right-hand side are of very different sizes; weigh by the size of the results.
    let jv = jvp(differentiation, field, at, v);
    let w: Vec<f64> = w.iter().zip(&jv).map(|(w, j)| w / (1.0 + j.abs())).collect();
    let (left, right) = (dot(&w, &jv), dot(&vjp(differentiation, field, at, &w), v));
    prop_assert!((left - right).abs() < 1e-10, "{}: {left} {right}", differentiation.name());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn products_from_both_sides_agree(
        activation in 0..Activation::NAMES.len(),
        sealed: bool,
        hidden in proptest::collection::vec(1_usize..12, 1..3),
        x in -3.0..3.0_f64,
        velocity in -50.0..50.0_f64,
        air in 0.02..0.15_f64,
        seed in 0.0..10.0_f64,
    ) {
        let (mut y, u) = operating_point(sealed);
        (y[0], y[1]) = (x, velocity);
        if !sealed {
            y[4] = air;
        }
        let w: Vec<f64> = (0..y.len()).map(|k| (seed * 1.3 + k as f64).cos()).collect();
        let field = joint(network(Activation::NAMES[activation], &hidden), sealed);
        let v = direction(&field, At { t: 0.0, y: &y, u: &u }, seed);
        identity(&ByTape, &field, (&y, &u), (&w, &v))?;
        identity(&ByDual, &field, (&y, &u), (&w, &v))?;
        identity(&ByHand, &field, (&y, &u), (&w, &v))?;
        identity(&ByChunk::<5>, &field, (&y, &u), (&w, &v))?;
        let field = joint(spring(), sealed);
        let v = direction(&field, At { t: 0.0, y: &y, u: &u }, seed);
        identity(&ByTape, &field, (&y, &u), (&w, &v))?;
        identity(&ByDual, &field, (&y, &u), (&w, &v))?;
    }
}
