use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use proptest::prelude::*;

fn value(seed: u32, k: usize) -> f64 {
    (f64::from(seed) + k as f64 * 0.7391).sin()
}

proptest! {
    #[test]
    fn equals_the_plain_sum(
        vectors in 1_usize..9,
        inner in 0_usize..200,
        columns in 0_usize..11,
        by_rows in any::<bool>(),
        seed in 0_u32..1000,
    ) {
        let rows = 16 * vectors;
        let a: Vec<f64> = (0..rows * inner).map(|k| value(seed, k)).collect();
        let b: Vec<f64> = (0..inner * columns).map(|k| value(seed + 1, k)).collect();
        let start: Vec<f64> = (0..rows * columns).map(|k| value(seed + 2, k)).collect();
        let (layout, b_stride) =
            if by_rows { (Layout::Rows, columns) } else { (Layout::Columns, inner) };
        let held = vec![0.5; rows * columns];
        for begin in [
            Start::Held,
            Start::Zero,
            Start::Columns(&start),
            Start::Columns(&start[..rows.min(start.len())]),
        ] {
            let mut c = held.clone();
            let (a, b, start_with) = (&a, &b, begin);
            let product = |finish, c: &mut Vec<f64>| {
                let start = start_with;
                Product { rows, inner, columns, a, b, layout, b_stride, start, finish, c }
                    .run();
            };
            product(Finish::Store, &mut c);
            let mut finished = held.clone();
            product(Finish::Multiply(&start), &mut finished);
            for (f, (c, s)) in finished.iter().zip(c.iter().zip(&start)) {
                prop_assert_eq!(*f, c * s);
            }
            finished.copy_from_slice(&held);
            product(Finish::Gate { values: &start, slope: 0.1 }, &mut finished);
            for (f, (c, s)) in finished.iter().zip(c.iter().zip(&start)) {
                prop_assert_eq!(*f, if *s > 0.0 { *c } else { c * 0.1 });
            }
            finished.copy_from_slice(&held);
            product(Finish::LeakyRelu(0.1), &mut finished);
            for (f, c) in finished.iter().zip(&c) {
                prop_assert_eq!(*f, if *c > 0.0 { *c } else { 0.1 * c });
            }
            for j in 0..columns {
                for i in 0..rows {
                    let b_at = |k| if by_rows { b[k * columns + j] } else { b[j * inner + k] };
                    let sum: f64 = (0..inner).map(|k| a[k * rows + i] * b_at(k)).sum();
                    let first = match begin {
                        Start::Held => 0.5,
                        Start::Zero => 0.0,
                        Start::Columns(c) if c.len() == rows => c[i],
                        Start::Columns(c) => c[j * rows + i],
                    };
                    prop_assert!((c[j * rows + i] - first - sum).abs() < 1e-11);
                }
            }
        }
    }
}

/// A column's result is the same bits alone and in any company.
#[test]
fn columns_do_not_depend_on_their_neighbours() {
    let (rows, inner, columns) = (96, 96, 23);
    let a: Vec<f32> = (0..rows * inner).map(|k| value(3, k) as f32).collect();
    let b: Vec<f32> = (0..inner * columns).map(|k| value(4, k) as f32).collect();
    let product = |b: &[f32], columns: usize| {
        let mut c = vec![0.0; rows * columns];
        let (a, c_mut, b_stride) = (&a[..], &mut c[..], inner);
        let (layout, start, finish) = (Layout::Columns, Start::Zero, Finish::Store);
        Product { rows, inner, columns, a, b, layout, b_stride, start, finish, c: c_mut }.run();
        c
    };
    let together = product(&b, columns);
    for j in 0..columns {
        let alone = product(&b[j * inner..(j + 1) * inner], 1);
        assert_eq!(alone, together[j * rows..(j + 1) * rows]);
    }
}
