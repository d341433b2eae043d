//! Nothing is allocated once workspaces are warm.

use num_dual::DualNum;
use pam_autodiff::{
    At, ByDual, ByHand, ByTape, Cotangent, DifferentiableField, Differentiation, Function, Point,
    Recorder, Tangent, Tape, gradient_into, hessian_vector_into, jacobian_forward_into,
    jacobian_reverse_into, jvp_into, vjp_into,
};
use pam_core::{ParametricField, Scalar};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

#[path = "all/support/mod.rs"]
mod support;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|c| c.set(c.get() + 1));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of the second and third run.
fn allocations(mut run: impl FnMut()) -> usize {
    run();
    let before = COUNT.with(Cell::get);
    run();
    run();
    COUNT.with(Cell::get) - before
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0; 3]))), 2);
}

#[test]
fn a_warm_tape_does_not_allocate() {
    let mut tape = Tape::<f64>::new();
    let x = tape.variable(0.5);
    let mark = tape.mark();
    let count = allocations(|| {
        tape.rewind(mark);
        let y = tape.record(|| (0..10_000).fold(x, |y, _| (y * x).sin() + x));
        assert!(tape.reverse([(y, 1.0)]).of(x).is_finite());
        assert!(tape.forward([(x, 1.0)]).of(y).is_finite());
    });
    assert_eq!(count, 0);
}

/// Products in both directions; `moving` says whether the parameter direction changes between calls.
fn field_allocations<D: Differentiation<F>, F: ParametricField>(
    differentiation: &D,
    field: &F,
    sealed: bool,
    moving: bool,
) -> usize {
    let (y, u) = support::operating_point(sealed);
    let field = differentiation.of(field);
    let mut work = field.workspace();
    let mut v = vec![0.1; field.parameter_len()];
    let mut sums = (y.clone(), u.clone(), v.clone());
    let mut dy = y.clone();
    let mut t = 0.0;
    allocations(|| {
        t += 0.1;
        let at = At { t, y: &y, u: &u };
        if moving {
            v[0] += 0.1;
        }
        field.eval_into(at, &mut dy, &mut work);
        let s = Cotangent { y: &mut sums.0, u: &mut sums.1, p: &mut sums.2 };
        field.vjp_into(at, &y, s, &mut work);
        field.jvp_into(at, Tangent { y: &y, u: &u, p: &v }, &mut dy, &mut work);
    })
}

#[test]
fn warm_fields_do_not_allocate() {
    for sealed in [true, false] {
        for activation in ["leaky_relu", "gelu"] {
            let joint = support::joint(support::network(activation, &[24, 24]), sealed);
            assert_eq!(field_allocations(&ByTape, &joint, sealed, true), 0, "{activation}");
            assert_eq!(field_allocations(&ByDual, &joint, sealed, false), 0, "{activation}");
            assert_eq!(field_allocations(&ByHand, &joint, sealed, true), 0, "{activation}");
        }
        let joint = support::joint(support::spring(), sealed);
        assert_eq!(field_allocations(&ByTape, &joint, sealed, true), 0);
        assert_eq!(field_allocations(&ByDual, &joint, sealed, false), 0);
    }
}

#[test]
fn warm_drivers_do_not_allocate() {
    struct Norm;
    impl Function for Norm {
        fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
            out[0] = x.iter().map(|&x| x * x).sum::<S>().sqrt();
        }
    }
    let (x, v) = ([1.0; 20], [0.5; 20]);
    let (mut a, mut b, mut one) = ([0.0; 20], [0.0; 20], [0.0]);
    let (mut record, mut second) = (Recorder::new(), Recorder::new());
    let (mut dual, mut chunk) = (Point::new(), Point::new());
    let count = allocations(|| {
        gradient_into(&Norm, &x, &mut a, &mut record);
        vjp_into(&Norm, &x, &[1.0], &mut a, &mut record);
        jvp_into(&Norm, &x, &v, &mut one, &mut dual);
        jacobian_forward_into::<8>(&Norm, &x, &mut a, &mut chunk);
        jacobian_reverse_into(&Norm, &x, &mut a, &mut record);
        hessian_vector_into(&Norm, &x, &v, &mut a, &mut b, &mut second);
    });
    assert_eq!(count, 0);
}
