//! Products of a joint's Jacobians with vectors, against plain evaluations.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use num_dual::{Dual64, HyperDual64};
use pam_autodiff::{
    At, ByDual, ByHand, ByTape, Chunk, Cotangent, DifferentiableField, Differentiation, Tangent,
};
use pam_core::{ForceInput, ForceModel, JointField, NetworkForce, ParametricField, Scalar, scalar};
use std::hint::black_box;

#[path = "../../pam-autodiff/tests/all/support/mod.rs"]
mod support;

fn products<D: Differentiation<JointField<f64, NetworkForce<f64>>>>(
    criterion: &mut Criterion,
    differentiation: &D,
    joint: &JointField<f64, NetworkForce<f64>>,
    name: &str,
) {
    let field = differentiation.of(joint);
    let mut work = field.workspace();
    let (y, u) = support::operating_point(true);
    let at = At { t: 0.0, y: &y, u: &u };
    let w = [0.3, -1.0, 0.2, 0.1];
    let direction: Vec<f64> = (0..joint.parameter_len()).map(|k| (k as f64).cos()).collect();
    let (mut y_sum, mut u_sum) = ([0.0; 4], [0.0; 1]);
    let (mut p_sum, mut dy) = (vec![0.0; joint.parameter_len()], [0.0; 4]);
    let mut group = criterion.benchmark_group(format!("{name} by {}", differentiation.name()));
    group.sample_size(20);
    group.bench_function("evaluation", |b| {
        b.iter(|| field.eval_into(black_box(at), &mut dy, &mut work));
    });
    group.bench_function("jvp", |b| {
        let v = Tangent { y: &w, u: &[1.0], p: &direction };
        b.iter(|| field.jvp_into(black_box(at), v, &mut dy, &mut work));
    });
    group.bench_function("vjp", |b| {
        b.iter(|| {
            let sums = Cotangent { y: &mut y_sum, u: &mut u_sum, p: &mut p_sum };
            field.vjp_into(black_box(at), &w, sums, &mut work);
        });
    });
    group.finish();
}

fn joints(criterion: &mut Criterion) {
    for activation in ["leaky_relu", "tanh"] {
        let joint = support::joint(support::network(activation, &[96, 96]), true);
        products(criterion, &ByTape, &joint, &format!("96x96 {activation}"));
        products(criterion, &ByHand, &joint, &format!("96x96 {activation}"));
    }
    let small = support::joint(support::network("tanh", &[8]), true);
    products(criterion, &ByTape, &small, "8 tanh");
    products(criterion, &ByDual, &small, "8 tanh");
}

/// One evaluation of a force with each forward number.
fn numbers(criterion: &mut Criterion) {
    fn force<S: Scalar>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str) {
        let force = support::network("leaky_relu", &[96, 96]).map(S::constant);
        let input = ForceInput {
            displacement_mm: S::constant(0.7),
            velocity_mm_s: S::constant(-3.0),
            mass_flexor_g: S::constant(0.06),
            mass_extensor_g: S::constant(0.08),
        };
        let mut work = scalar::zeros(force.work_len());
        group.bench_function(name, |b| {
            b.iter(|| force.restoring_force_mn(black_box(&input), &mut work).real());
        });
    }
    let mut group = criterion.benchmark_group("96x96 force with");
    group.sample_size(20);
    force::<f64>(&mut group, "f64");
    force::<Dual64>(&mut group, "Dual64");
    force::<Chunk<4>>(&mut group, "Chunk<4>");
    force::<Chunk<8>>(&mut group, "Chunk<8>");
    force::<HyperDual64>(&mut group, "HyperDual64");
    group.finish();
}

criterion_group!(benches, joints, numbers);
criterion_main!(benches);
