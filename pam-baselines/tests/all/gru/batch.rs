use pam_baselines::gru::{BatchGradient, INPUTS, Network, Shape, Window};

/// The same loss and gradient, to the bit, with one thread and with several.
#[test]
fn threads_change_nothing() {
    let shape = Shape { hidden: 16, layers: 2 };
    let network = Network::<f32>::new(shape, &shape.random(2));
    let data: Vec<Vec<[f32; INPUTS]>> = (0..70)
        .map(|w| {
            (0..8).map(|t| std::array::from_fn(|c| ((w * 7 + t * 3 + c) as f32).sin())).collect()
        })
        .collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let windows: Vec<Window<'_, f32>> =
                data.iter().map(|s| Window { samples: s }).collect();
            let mut gradient = vec![0.0; shape.len()];
            let mut engine = BatchGradient::new(&network, 70, 4, 4);
            (engine.run(&network, &windows, Some(&mut gradient)), gradient)
        })
    };
    assert_eq!(run(1), run(3));
}
