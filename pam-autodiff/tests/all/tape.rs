//! What a tape records, keeps and refuses.

use num_dual::{Dual64, DualNum};
use pam_autodiff::{Tape, Var};
use pam_core::{ParametricField, Scalar, VectorField, scalar};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::support;

fn panics<R>(f: impl FnOnce() -> R) -> bool {
    catch_unwind(AssertUnwindSafe(f)).is_err()
}

#[test]
fn constants_record_nothing_and_need_no_tape() {
    let (a, b) = (Var::<f64>::constant(2.0), Var::constant(3.0));
    let c = (a * b).sin() + a.powf(1.5) - Scalar::softplus(b);
    assert!(c.is_constant());
    let mut tape = Tape::<f64>::new();
    let x = tape.variable(1.0);
    let before = tape.len();
    let (kept, counted) = tape.record(|| (a * b + c, x * a));
    assert!(kept.is_constant() && !counted.is_constant());
    assert_eq!(tape.len(), before + 1);
    let mut out = [a; 2];
    Var::affine_into(&[a, b, a, b], &[a, a], &[b, b], &mut out);
    assert!(out.iter().all(|o| o.is_constant()) && out[0].value() == 14.0);
}

#[test]
fn recordings_nest() {
    // d/dx [x · g(x)] with g = d/ds (s² x) at s = 3, worked out on an inner tape for the value of x.
    let mut outer = Tape::<f64>::new();
    let x = outer.variable(5.0);
    let result = outer.record(|| {
        let before = x * x;
        let mut inner = Tape::<f64>::new();
        let s = inner.variable(3.0);
        let z = inner.record(|| s * s * Var::constant(x.value()));
        let slope = inner.reverse([(z, 1.0)]).of(s);
        assert_eq!(slope, 30.0);
        before + x * Var::constant(slope)
    });
    assert_eq!(outer.reverse([(result, 1.0)]).of(x), 40.0);
}

#[test]
fn a_panic_ends_the_recording_and_nothing_else() {
    let (mut outer, mut inner) = (Tape::<f64>::new(), Tape::<f64>::new());
    let (x, s) = (outer.variable(2.0), inner.variable(3.0));
    let result = outer.record(|| {
        let before = x * x;
        assert!(panics(|| inner.record(|| {
            let _ = s * s;
            panic!("on purpose")
        })));
        before * x
    });
    assert_eq!(outer.reverse([(result, 1.0)]).of(x), 12.0);
    let again = inner.record(|| s * s);
    assert_eq!(inner.reverse([(again, 1.0)]).of(s), 6.0);
    assert!(panics(|| s + s), "no tape records any more");
}

#[test]
fn tapes_do_not_mix() {
    let (mut a, mut b) = (Tape::<f64>::new(), Tape::<f64>::new());
    let (x, y) = (a.variable(1.0), b.variable(2.0));
    assert!(panics(|| x + x), "no tape records");
    assert!(panics(|| a.record(|| x * y)));
    assert!(panics(|| a.record(|| y.sin())));
    assert!(panics(|| a.reverse([(y, 1.0)]).of(x)));
    assert!(panics(|| a.reverse([(x, 1.0)]).of(y)));
    for weights in [[x, y], [y, y], [y, x]] {
        assert!(panics(|| a.record(|| Var::affine_into(&weights, &[x], &[x, x], &mut [x]))));
    }
    a.clear();
    assert!(panics(|| a.record(|| x + x)), "variables do not outlive a clearing");
}

#[test]
fn what_is_before_the_mark_stays() {
    let mut tape = Tape::<f64>::new();
    let raw = tape.variables(&[0.3, -0.7]);
    let derived = tape.record(|| raw[0].softplus() * raw[1].exp());
    let mark = tape.mark();
    let length = tape.len();
    for x in [0.5, 2.0, -1.0] {
        tape.rewind(mark);
        assert_eq!(tape.len(), length);
        let x_var = tape.variable(x);
        let result = tape.record(|| derived * x_var.sin());
        let adjoints = tape.reverse([(result, 1.0)]);
        let softplus = 0.3_f64.exp().ln_1p();
        let expected = x.sin() * (-0.7_f64).exp() / (1.0 + (-0.3_f64).exp());
        assert!((adjoints.of(raw[0]) - expected).abs() < 1e-15);
        assert!((adjoints.of(raw[1]) - x.sin() * softplus * (-0.7_f64).exp()).abs() < 1e-15);
    }
    tape.clear();
    assert!(tape.is_empty() && panics(|| tape.rewind(mark)));
}

#[test]
fn several_seeds_add_up() {
    let mut tape = Tape::<f64>::new();
    let x = tape.variable(2.0);
    let (square, cube) = tape.record(|| (x * x, x * x * x));
    let adjoints = tape.reverse([(square, 10.0), (cube, 1.0), (square, 1.0), (5.0.into(), 9.0)]);
    assert_eq!(adjoints.of(x), 11.0 * 4.0 + 12.0);
    let tangents = tape.forward([(x, 3.0)]);
    assert_eq!((tangents.of(square), tangents.of(cube)), (12.0, 36.0));
}

/// What nothing depends on stays zero, though its slope is infinite.
#[test]
fn infinite_slopes_reach_only_their_own() {
    let mut tape = Tape::<f64>::new();
    let (x, y) = (tape.variable(0.0), tape.variable(1.0));
    let (root, other) = tape.record(|| (x.sqrt(), x + y));
    assert_eq!(tape.reverse([(other, 1.0)]).of(x), 1.0);
    assert_eq!(tape.forward([(y, 1.0)]).of(root), 0.0);
    assert_eq!(tape.reverse([(root, 1.0)]).of(x), f64::INFINITY);
}

#[test]
fn single_precision() {
    let mut tape = Tape::<f32>::new();
    let x = tape.variable(0.5);
    let y = tape.record(|| x.exp() * 2.0);
    assert_eq!(tape.reverse([(y, 1.0)]).of(x), 2.0 * 0.5_f32.exp());
}

type Layer<T> = fn(&[Var<T>], &[Var<T>], &[Var<T>], &mut [Var<T>]);

/// The layer written out, operation by operation.
fn one_by_one<S: Scalar>(columns: &[S], bias: &[S], input: &[S], out: &mut [S]) {
    out.copy_from_slice(bias);
    for (column, &x) in columns.chunks_exact(out.len()).zip(input) {
        for (o, &w) in out.iter_mut().zip(column) {
            *o += w * x;
        }
    }
}

/// A layer as one block gives what its operations one by one give, for operands side by side, scattered,
/// constant and mixed, from both sides.
fn layer_equals_its_operations<T: pam_autodiff::tape::Element>(tolerance: f64) {
    const KINDS: usize = 4;
    for (outputs, inputs) in [(1, 1), (3, 2), (1, 20), (19, 5), (33, 17)] {
        for kinds in 0..KINDS.pow(3) {
            let mut tape = Tape::<T>::new();
            let mut k = 0;
            let mut value = || {
                k += 1;
                T::constant((f64::from(k) * 0.7).sin())
            };
            let lengths = [inputs * outputs, outputs, inputs];
            let mut operands = Vec::new();
            for (place, length) in lengths.into_iter().enumerate() {
                let values: Vec<T> = (0..length).map(|_| value()).collect();
                let mut vars = tape.variables(&values);
                match kinds / KINDS.pow(place as u32) % KINDS {
                    0 => {}
                    1 => vars.reverse(),
                    2 => vars.iter_mut().for_each(|v| *v = Var::constant_of(v.value())),
                    _ => vars.iter_mut().step_by(2).for_each(|v| *v = Var::constant_of(v.value())),
                }
                operands.push(vars);
            }
            let [columns, bias, input] = operands.try_into().unwrap();
            let run = |tape: &mut Tape<T>, layer: Layer<T>| {
                let mark = tape.mark();
                let mut out = vec![Var::constant_of(T::zero()); outputs];
                // Something before and after, so that runs of operations lie on both sides.
                let after = tape.record(|| {
                    let input: Vec<_> = input.iter().map(|&x| x * x).collect();
                    layer(&columns, &bias, &input, &mut out);
                    out.iter().map(|o| o.sin()).collect::<Vec<_>>()
                });
                let mut found: Vec<T> = after.iter().map(|a| a.value()).collect();
                let all = || columns.iter().chain(&bias).chain(&input).copied();
                let w = after.iter().enumerate().map(|(k, &a)| (a, T::constant(k as f64 - 0.5)));
                let adjoints = tape.reverse(w);
                found.extend(all().map(|var| adjoints.of(var)));
                let tangents = tape.forward(all().map(|x| (x, x.value())));
                found.extend(after.iter().map(|&a| tangents.of(a)));
                tape.rewind(mark);
                found
            };
            let (block, written_out) =
                (run(&mut tape, Var::affine_into), run(&mut tape, one_by_one));
            for (a, b) in block.iter().zip(&written_out) {
                let (a, b) = (a.real(), b.real());
                assert!((a - b).abs() < tolerance, "{outputs}x{inputs}, {kinds}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_layer_equals_its_operations() {
    layer_equals_its_operations::<f64>(1e-13);
    layer_equals_its_operations::<f32>(1e-3);
    layer_equals_its_operations::<Dual64>(1e-13);
}

/// A layer takes bytes for its outputs and not for its weights.
#[test]
fn a_layer_is_small() {
    let mut tape = Tape::<f64>::new();
    let values: Vec<f64> = (0..96 * 96).map(|k| f64::from(k).cos()).collect();
    let (columns, bias) = (tape.variables(&values), tape.variables(&values[..96]));
    let before = tape.bytes();
    let mut out = vec![Var::constant(0.0); 96];
    tape.record(|| Var::affine_into(&columns, &bias, &bias, &mut out));
    assert!(tape.bytes() - before < 1024, "{}", tape.bytes() - before);
    tape.record(|| one_by_one(&columns, &bias, &bias, &mut out));
    assert!(tape.bytes() - before > 500_000, "{}", tape.bytes() - before);
}

/// Values of a taped run are those of a plain run, bit by bit.
#[test]
fn values_are_those_of_a_plain_run() {
    let field = support::joint(support::network("gelu", &[96, 96]), true);
    let (y, u) = support::operating_point(true);
    let mut plain = [0.0; 4];
    field.eval_into(0.0, &y, &u, &mut plain, &mut vec![0.0; field.work_len()]);
    let mut tape = Tape::<f64>::new();
    let parameters = tape.variables(&field.parameters());
    let taped = tape.record(|| {
        let field = field.with_parameters(&parameters);
        let lift = |x: &[f64]| x.iter().map(|&x| Var::constant(x)).collect::<Vec<_>>();
        let mut dy = lift(&[0.0; 4]);
        let mut work = scalar::zeros(field.work_len());
        field.eval_into(0.0, &lift(&y), &lift(&u), &mut dy, &mut work);
        dy
    });
    assert_eq!(taped.iter().map(|d| d.value()).collect::<Vec<_>>(), plain);
}
