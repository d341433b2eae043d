//! Order conditions of every tableau, by rooted trees up to order five (Butcher).

use pam_solvers::Tableau;

/// The order conditions `Σ_i w_i Φ_i(t) = 1/γ(t)` of all rooted trees up to `order`, each as its
/// residual for the weights `w` on derivatives with nodes `c` and matrix `a`.
fn residuals(w: &[f64], c: &[f64], a: &[Vec<f64>], order: usize) -> Vec<f64> {
    let n = c.len();
    let mul = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(p, q)| p * q).collect::<Vec<f64>>();
    let apply = |x: &[f64]| {
        (0..n).map(|i| a[i].iter().zip(x).map(|(p, q)| p * q).sum()).collect::<Vec<f64>>()
    };
    let one = vec![1.0; n];
    let c1 = c.to_vec();
    let (c2, ac) = (mul(&c1, &c1), apply(&c1));
    let (c3, ac2, aac, cac) = (mul(&c2, &c1), apply(&c2), apply(&ac), mul(&c1, &ac));
    let trees: [Vec<(Vec<f64>, f64)>; 5] = [
        vec![(one, 1.0)],
        vec![(c1.clone(), 2.0)],
        vec![(c2.clone(), 3.0), (ac.clone(), 6.0)],
        vec![(c3.clone(), 4.0), (cac.clone(), 8.0), (ac2.clone(), 12.0), (aac.clone(), 24.0)],
        vec![
            (mul(&c2, &c2), 5.0),
            (mul(&c2, &ac), 10.0),
            (mul(&ac, &ac), 20.0),
            (mul(&c1, &ac2), 15.0),
            (mul(&c1, &aac), 30.0),
            (apply(&c3), 20.0),
            (apply(&cac), 40.0),
            (apply(&ac2), 60.0),
            (apply(&aac), 120.0),
        ],
    ];
    trees[..order]
        .iter()
        .flatten()
        .map(|(phi, gamma)| w.iter().zip(phi).map(|(p, q)| p * q).sum::<f64>() - 1.0 / gamma)
        .collect()
}

/// Nodes and matrix with the FSAL stage as a further one.
fn with_fsal(t: &Tableau) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut c = t.c.clone();
    c.push(1.0);
    let mut a = t.a.clone();
    a.push(t.b.clone());
    (c, a)
}

fn largest(values: Vec<f64>) -> f64 {
    values.into_iter().fold(0.0, |m, v| m.max(v.abs()))
}

#[test]
fn steps_meet_their_order_conditions_and_no_more() {
    for name in Tableau::NAMES {
        let t = Tableau::from_name(name).unwrap();
        t.validate().unwrap();
        assert!(largest(residuals(&t.b, &t.c, &t.a, t.order)) < 1e-14, "{name}");
        if t.order < 5 {
            assert!(largest(residuals(&t.b, &t.c, &t.a, t.order + 1)) > 1e-4, "{name}");
        }
    }
}

#[test]
fn embedded_methods_meet_their_order_conditions_and_no_more() {
    for name in Tableau::NAMES {
        let t = Tableau::from_name(name).unwrap();
        let Some(error) = &t.error else { continue };
        let order = t.embedded_order.unwrap();
        let (c, a) = with_fsal(&t);
        let hat: Vec<f64> = t.b.iter().chain(&[0.0]).zip(error).map(|(b, e)| b - e).collect();
        assert!(largest(residuals(&hat, &c, &a, order)) < 2e-14, "{name}");
        assert!(largest(residuals(&hat, &c, &a, order + 1)) > 1e-4, "{name}");
    }
}

/// `b_i(θ)` meet the order conditions of a step of length θ: `Σ b_i(θ) Φ_i = θ^r / γ`.
#[test]
fn interpolants_meet_their_order_conditions() {
    for name in Tableau::NAMES {
        let t = Tableau::from_name(name).unwrap();
        let (c, a) = with_fsal(&t);
        for theta in [0.1, 0.37, 0.5, 0.81] {
            // Scaling nodes and matrix by 1/θ and weights by 1/θ turns the conditions into those of
            // a full step.
            let w: Vec<f64> = (0..t.stages_with_fsal())
                .map(|i| t.interpolation_weight(i, theta) / theta)
                .collect();
            let c: Vec<f64> = c.iter().map(|v| v / theta).collect();
            let a: Vec<Vec<f64>> =
                a.iter().map(|r| r.iter().map(|v| v / theta).collect()).collect();
            let residual = largest(residuals(&w, &c, &a, t.interpolant_order));
            assert!(residual < 1e-10, "{name} at θ = {theta}: {residual:e}");
        }
        for i in 0..t.stages() {
            assert!((t.interpolation_weight(i, 1.0) - t.b[i]).abs() < 1e-13, "{name} {i}");
        }
        assert!(t.interpolation_weight(t.stages(), 1.0).abs() < 1e-13, "{name}");
    }
}

#[test]
fn a_custom_method_is_checked() {
    let heun = Tableau::custom("heun", 2, &[0.0, 1.0], &[&[], &[1.0]], &[0.5, 0.5]).unwrap();
    assert_eq!(heun.stages(), 2);
    let wrong = Tableau::custom("wrong", 2, &[0.0, 0.5], &[&[], &[1.0]], &[0.5, 0.5]);
    assert!(wrong.unwrap_err().to_string().contains("row 1"));
    assert!(Tableau::from_name("rk5").unwrap_err().to_string().contains("tsit5"));
}
