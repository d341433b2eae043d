use pam_baselines::neural_ode::{Field, Tape, Window, parameter_len, random};

fn windows(steps: usize) -> Vec<Window<f64>> {
    (0..3)
        .map(|w| {
            let wave = |t: usize, c: usize| (0.4 * t as f64 + w as f64 + 1.3 * c as f64).sin();
            Window {
                states: (0..=steps).map(|t| std::array::from_fn(|c| wave(2 * t, c))).collect(),
                forces: (0..=2 * steps).map(|t| wave(t, 4)).collect(),
            }
        })
        .collect()
}

#[test]
fn the_gradient_is_that_of_the_loss() {
    let (width, steps) = (16, 4);
    let numbers = random(width, 7);
    let data = windows(steps);
    let data: Vec<&Window<f64>> = data.iter().collect();
    let rates = [1.0, 2.0, 0.5, 0.7];
    let loss = |numbers: &[f64]| {
        let field = Field::new(width, numbers, rates);
        Tape::new(width, 3, steps, 0.2).run(&field, &data, None)
    };
    let mut gradient = vec![0.0; parameter_len(width)];
    let field = Field::new(width, &numbers, rates);
    Tape::new(width, 3, steps, 0.2).run(&field, &data, Some(&mut gradient));
    for at in (0..numbers.len()).step_by(11).chain([numbers.len() - 1]) {
        let h = 1e-5;
        let (mut up, mut down) = (numbers.clone(), numbers.clone());
        up[at] += h;
        down[at] -= h;
        let difference = (loss(&up) - loss(&down)) / (2.0 * h);
        let scale = difference.abs().max(1e-2);
        assert!((gradient[at] - difference).abs() < 1e-6 * scale, "{at}");
    }
}
