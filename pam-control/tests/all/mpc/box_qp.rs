use pam_control::mpc::box_qp::BoxQp;

/// The conditions of Karush, Kuhn and Tucker, which are sufficient for a convex program: the gradient `H u + q` is zero
/// between the bounds and points outwards at them. As every eigenvalue of `H` is at least 0.01, a solution that misses them
/// by 1e-8 is within 1e-6 of the minimum.
#[test]
fn random_programs_are_solved_to_their_optimality_conditions() {
    let n = 24;
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut at_a_bound = 0;
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
        let (low, high) = (-0.3, 0.2);
        let mut u = vec![0.0; n];
        BoxQp::new(n).solve(&h, &q, &vec![low; n], &vec![high; n], &mut u);

        for i in 0..n {
            let gradient = q[i] + (0..n).map(|j| h[i * n + j] * u[j]).sum::<f64>();
            assert!((low..=high).contains(&u[i]), "{}", u[i]);
            let outwards = if u[i] == low {
                gradient.max(0.0)
            } else if u[i] == high {
                gradient.min(0.0)
            } else {
                0.0
            };
            at_a_bound += usize::from(u[i] == low || u[i] == high);
            assert!((gradient - outwards).abs() < 1e-8, "variable {i}: {} {gradient:e}", u[i]);
        }
    }
    // Both kinds of variables occur.
    assert!((20..20 * n - 20).contains(&at_a_bound), "{at_a_bound}");
}
