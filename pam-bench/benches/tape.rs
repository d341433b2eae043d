//! What an operation on the tape costs, to record and to sweep over, and a dense layer as one block.

use criterion::{Criterion, criterion_group, criterion_main};
use pam_autodiff::{Tape, Var};
use pam_core::Scalar;
use std::hint::black_box;

fn operations(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("1000 multiplications and 1000 additions");
    let mut tape = Tape::<f64>::new();
    let (a, b) = (tape.variable(0.99), tape.variable(0.01));
    let mark = tape.mark();
    let run = |x: Var| (0..1000).fold(x, |x, _| a * x + b);
    group.bench_function("record", |bench| {
        bench.iter(|| {
            tape.rewind(mark);
            tape.record(|| run(black_box(a)))
        });
    });
    let result = tape.record(|| run(a));
    group.bench_function("reverse", |bench| bench.iter(|| tape.reverse([(result, 1.0)]).of(a)));
    group.bench_function("forward", |bench| bench.iter(|| tape.forward([(a, 1.0)]).of(result)));
    group.finish();
}

fn layers(criterion: &mut Criterion) {
    const N: usize = 96;
    let mut group = criterion.benchmark_group("layer of 96x96");
    let mut tape = Tape::<f64>::new();
    let values: Vec<f64> = (0..N * N).map(|k| (k as f64).sin()).collect();
    let (columns, bias) = (tape.variables(&values), tape.variables(&values[..N]));
    let mark = tape.mark();
    let mut out = vec![Var::constant(0.0); N];
    group.bench_function("record as a block", |bench| {
        bench.iter(|| {
            tape.rewind(mark);
            tape.record(|| Var::affine_into(&columns, &bias, &bias, &mut out));
        });
    });
    let bytes = tape.bytes();
    group.bench_function("reverse as a block", |bench| {
        bench.iter(|| tape.reverse(out.iter().map(|&o| (o, 1.0))).of(columns[0]));
    });
    let one_by_one = |out: &mut [Var]| {
        out.copy_from_slice(&bias);
        for (column, &x) in columns.chunks_exact(N).zip(&bias) {
            for (o, &w) in out.iter_mut().zip(column) {
                *o += w * x;
            }
        }
    };
    group.bench_function("record one by one", |bench| {
        bench.iter(|| {
            tape.rewind(mark);
            tape.record(|| one_by_one(&mut out));
        });
    });
    println!("bytes as a block {bytes}, one by one {}", tape.bytes());
    group.bench_function("reverse one by one", |bench| {
        bench.iter(|| tape.reverse(out.iter().map(|&o| (o, 1.0))).of(columns[0]));
    });
    group.finish();
}

criterion_group!(benches, operations, layers);
criterion_main!(benches);
