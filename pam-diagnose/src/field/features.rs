//! Features of states and inputs, for the flexible model.

/// Powers, directions, inputs and products of states and inputs, each by itself and growing with time. A direction turns
/// over a part of the root mean square, `direction_width`.
pub(super) fn features(
    states: &[Vec<f64>],
    inputs: &[Vec<f64>],
    direction_width: f64,
) -> Vec<Vec<f64>> {
    let rows = states.first().map_or(0, Vec::len);
    let scaled = |series: &Vec<f64>| -> Vec<f64> {
        let size = pam_numerics::statistics::root_mean_square(series).max(1e-12);
        series.iter().map(|v| v / size).collect()
    };
    let states: Vec<Vec<f64>> = states.iter().map(scaled).collect();
    let inputs: Vec<Vec<f64>> = inputs.iter().map(scaled).collect();
    let map = |y: &[f64], f: &dyn Fn(f64) -> f64| y.iter().map(|&v| f(v)).collect::<Vec<f64>>();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
    let mut all = vec![vec![1.0; rows]];
    for (i, y) in states.iter().enumerate() {
        let direction = map(y, &|v| (v / direction_width).tanh());
        all.extend([y.clone(), map(y, &|v| v.powi(3)), direction]);
        all.push(map(y, &|v| v * v.abs()));
        all.extend(states[i..].iter().chain(&inputs).map(|other| product(y, other)));
    }
    for u in &inputs {
        all.extend([u.clone(), map(u, &|v| v.powi(3))]);
    }
    let time: Vec<f64> = (0..rows).map(|k| k as f64 / rows as f64).collect();
    let growing: Vec<Vec<f64>> = all.iter().map(|f| product(f, &time)).collect();
    all.extend(growing);
    all
}
