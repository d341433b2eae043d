//! How near the batched network comes to the machine's matrix product.
//!
//! The peak is the fastest square product found, of this project's kernel, `ndarray`
//! (`matrixmultiply`) and `faer`, measured in the same run on the same number of threads. A pass
//! counts the multiplications of its dense layers only; activations are overhead.

use pam_autodiff::batch::BatchNetwork;
use pam_bench::published_model;
use pam_core::AnyForce;
use pam_core::simd::Float;
use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// The square size of the peak.
const SQUARE: usize = 768;
/// Points of a block, and members of a batch.
const POINTS: [usize; 3] = [15, 128, 256];
/// Time spent on each figure, s.
const SECONDS: f64 = 0.4;

/// Best rate (10⁹ floating-point operations a second, over all threads) of `work`, which does
/// `operations` of them.
fn rate<W: Send>(
    threads: usize,
    operations: f64,
    make: impl Fn() -> W + Sync,
    work: impl Fn(&mut W) + Sync,
) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(|| {
        (0..threads)
            .into_par_iter()
            .with_max_len(1)
            .map(|_| {
                let mut state = make();
                work(&mut state);
                let batch = (2e6 / operations).ceil().max(1.0) as usize;
                let (mut best, begin) = (f64::INFINITY, Instant::now());
                while begin.elapsed().as_secs_f64() < SECONDS {
                    let start = Instant::now();
                    for _ in 0..batch {
                        work(&mut state);
                    }
                    best = best.min(start.elapsed().as_secs_f64() / batch as f64);
                }
                operations / best / 1e9
            })
            .sum()
    })
}

fn numbers<T: Float>(len: usize) -> Vec<T> {
    (0..len).map(|k| T::narrow((k as f64 * 0.739).sin())).collect()
}

/// Rates of the candidates for the square product, and of the product at the layer's own shape.
fn products<T: Float + ndarray::LinalgScalar + faer::traits::ComplexField>(threads: usize) -> f64 {
    let mut peak = 0.0_f64;
    for (rows, inner, columns) in
        [(SQUARE, SQUARE, SQUARE), (96, 96, 8), (96, 96, 29), (96, 96, 256)]
    {
        let operations = 2.0 * (rows * inner * columns) as f64;
        let make = || {
            (
                numbers::<T>(rows * inner),
                numbers::<T>(inner * columns),
                numbers::<T>(rows * columns),
            )
        };
        let own = rate(threads, operations, make, |(a, b, c)| {
            let (layout, start, finish) = (Layout::Columns, Start::Zero, Finish::Store);
            let b_stride = inner;
            Product { rows, inner, columns, a, b, layout, b_stride, start, finish, c }.run();
            black_box(c);
        });
        let by_ndarray = rate(
            threads,
            operations,
            || {
                use ndarray::ShapeBuilder;
                let (a, b, c) = make();
                let array = |r: usize, c: usize, v: Vec<T>| {
                    ndarray::Array2::from_shape_vec((r, c).f(), v).expect("the lengths fit")
                };
                (array(rows, inner, a), array(inner, columns, b), array(rows, columns, c))
            },
            |(a, b, c)| {
                let zero = T::default();
                ndarray::linalg::general_mat_mul(T::narrow(1.0), a, b, zero, c);
                black_box(c);
            },
        );
        let by_faer = rate(threads, operations, make, |(a, b, c)| {
            use faer::{Accum, MatMut, MatRef, Par};
            let a = MatRef::from_column_major_slice(a, rows, inner);
            let b = MatRef::from_column_major_slice(b, inner, columns);
            let c = MatMut::from_column_major_slice_mut(c, rows, columns);
            faer::linalg::matmul::matmul(c, Accum::Replace, a, b, T::narrow(1.0), Par::Seq);
        });
        println!(
            "| {} | {threads} | {rows}×{inner}×{columns} | {own:.1} | {by_ndarray:.1} | {by_faer:.1} |",
            T::NAME
        );
        if rows == SQUARE {
            peak = own.max(by_ndarray).max(by_faer);
        }
    }
    peak
}

/// Rates of the network's passes beside the peak.
fn passes<T: Float>(threads: usize, peak: f64) {
    let AnyForce::Network(force) = published_model().force else {
        panic!("a network is published")
    };
    let network = BatchNetwork::<T>::new(force.mlp(), 2);
    let layers = force.mlp().layers();
    // Of the first layer two inputs vary; the others are folded into the bias.
    let pairs: usize =
        layers.iter().map(|l| l.inputs() * l.outputs()).sum::<usize>() - 2 * layers[0].outputs();
    for points in POINTS {
        let operations = 2.0 * (pairs * points) as f64;
        let bias = network.fold(&[0.05, 0.06]);
        let input = numbers::<T>(points * network.input_stride());
        let ones = vec![T::narrow(1.0); points];
        let make = || {
            let mut block = network.block(points);
            let mut out = vec![T::default(); points * network.output_stride()];
            let mut pulled = vec![T::default(); points * network.inputs()];
            network.forward_into(points, &bias, &input, &mut out, &[], &mut block);
            network.pull_back(points, &ones, &mut pulled, &[], &mut block);
            (block, out, pulled, network.sums(points))
        };
        let all = [
            rate(threads, operations, make, |(block, out, ..)| {
                network.values_into(points, &bias, &input, out, &mut [], block);
            }),
            rate(threads, operations, make, |(block, out, ..)| {
                network.forward_into(points, &bias, &input, out, &[], block);
            }),
            rate(threads, operations, make, |(block, _, pulled, _)| {
                network.pull_back(points, &ones, pulled, &[], block);
            }),
            rate(threads, operations, make, |(block, _, _, sums)| {
                network.accumulate(points, &ones, &input, &ones, &[], sums, block);
            }),
        ];
        let cells: Vec<String> =
            all.iter().map(|r| format!("{r:.1} ({:.0} %)", 100.0 * r / peak)).collect();
        println!("| {} | {threads} | {points} | {} |", T::NAME, cells.join(" | "));
    }
}

fn main() {
    println!("Rates in GFLOP/s; best of repeated runs.\n");
    println!("| float | threads | product | pam | ndarray | faer |\n|---|---|---|---|---|---|");
    let mut peaks = Vec::new();
    for threads in [1, 2] {
        peaks.push((threads, products::<f32>(threads), products::<f64>(threads)));
    }
    println!("\nPasses of the 96×96 network, and their share of the square peak.\n");
    println!("| float | threads | points | values | forward | pull back | accumulate |");
    println!("|---|---|---|---|---|---|---|");
    for (threads, f32_peak, f64_peak) in peaks {
        passes::<f32>(threads, f32_peak);
        passes::<f64>(threads, f64_peak);
    }
}
