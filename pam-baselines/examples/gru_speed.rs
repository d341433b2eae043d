//! Seconds of a training step of the GRU on made-up windows: `gru_speed BATCH STEPS` prints a JSON line with
//! the median. `pam-bench/peers/gru_speed.py` runs it in turns with PyTorch.

use pam_baselines::gru::{BatchGradient, INPUTS, Network, Shape, Window};
use pam_train::optimiser::{Adam, AdamSettings, clip_to_norm};
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|a| a.parse::<usize>().expect("numbers"));
    let batch = arguments.next().expect("BATCH");
    let steps = arguments.next().expect("STEPS");
    let shape = Shape { hidden: 96, layers: 2 };
    let mut numbers = shape.random(1);
    let data: Vec<Vec<[f32; INPUTS]>> = (0..batch)
        .map(|w| {
            (0..200)
                .map(|t| {
                    std::array::from_fn(|c| {
                        (0.05 * t as f32 + 0.7 * w as f32 + 0.9 * c as f32).sin()
                    })
                })
                .collect()
        })
        .collect();
    let windows: Vec<Window<'_, f32>> = data.iter().map(|s| Window { samples: s }).collect();
    let mut adam = Adam::new(AdamSettings::default(), numbers.len());
    let mut gradient = vec![0.0; numbers.len()];
    let mut engine = BatchGradient::new(&Network::new(shape, &numbers), batch, 100, 100);
    let mut seconds = Vec::new();
    let mut loss = 0.0;
    for _ in 0..=steps {
        let begun = Instant::now();
        let network = Network::new(shape, &numbers);
        loss = engine.run(&network, &windows, Some(&mut gradient));
        clip_to_norm(&mut gradient, 1.0);
        adam.step(&mut numbers, &gradient, 1e-3);
        seconds.push(begun.elapsed().as_secs_f64());
    }
    // The first step warms caches up.
    seconds.remove(0);
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    println!("{{\"batch\": {batch}, \"step_s\": {median}, \"loss\": {loss}}}");
}
