//! Products of a joint's Jacobians with vectors, against plain evaluations.

use criterion::{Criterion, criterion_group, criterion_main};
use pam_autodiff::{At, ByDual, ByTape, Cotangent, DifferentiableField, Differentiation, Tangent};
use pam_core::{JointField, NetworkForce, ParametricField};
use std::hint::black_box;

#[path = "../tests/support/mod.rs"]
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
    }
    let small = support::joint(support::network("tanh", &[8]), true);
    products(criterion, &ByTape, &small, "8 tanh");
    products(criterion, &ByDual, &small, "8 tanh");
}

criterion_group!(benches, joints);
criterion_main!(benches);
