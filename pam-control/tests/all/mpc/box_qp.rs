use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SupportedConeT};
use pam_control::mpc::box_qp::BoxQp;

/// Random programs, solved by Clarabel too.
#[test]
fn an_interior_point_library_agrees() {
    let n = 24;
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for _ in 0..20 {
        let a: Vec<f64> = (0..n * n).map(|_| random()).collect();
        let mut h = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                h[i * n + j] = (0..n).map(|k| a[k * n + i] * a[k * n + j]).sum::<f64>();
            }
            h[i * n + i] += 0.01;
        }
        let q: Vec<f64> = (0..n).map(|_| random()).collect();
        let (low, high) = (vec![-0.3; n], vec![0.2; n]);
        let mut u = vec![0.0; n];
        BoxQp::new(n).solve(&h, &q, &low, &high, &mut u);

        let rows: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| if j >= i { h[i * n + j] } else { 0.0 }).collect())
            .collect();
        let p = CscMatrix::from(&rows);
        let one = |i: usize, sign: f64| {
            (0..n).map(|j| if i == j { sign } else { 0.0 }).collect::<Vec<f64>>()
        };
        let constraints: Vec<Vec<f64>> =
            (0..n).map(|i| one(i, 1.0)).chain((0..n).map(|i| one(i, -1.0))).collect();
        let bounds: Vec<f64> = high.iter().copied().chain(low.iter().map(|l| -l)).collect();
        let settings = DefaultSettingsBuilder::default().verbose(false).build().unwrap();
        let mut solver = DefaultSolver::new(
            &p,
            &q,
            &CscMatrix::from(&constraints),
            &bounds,
            &[SupportedConeT::NonnegativeConeT(2 * n)],
            settings,
        )
        .unwrap();
        solver.solve();
        for (ours, theirs) in u.iter().zip(&solver.solution.x) {
            assert!((ours - theirs).abs() < 1e-5, "{ours} {theirs}");
        }
    }
}
