use pam_baselines::gru::{Begin, INPUTS, Network, Shape, Tape, Window};

fn samples(members: usize, len: usize) -> Vec<Vec<[f64; INPUTS]>> {
    (0..members)
        .map(|member| {
            (0..len)
                .map(|t| {
                    std::array::from_fn(|c| {
                        (0.31 * t as f64 + 0.7 * member as f64 + 1.3 * c as f64).sin()
                    })
                })
                .collect()
        })
        .collect()
}

/// The gradient against central differences of the loss in double precision, in every array, from rest
/// and where a block goes on.
#[test]
fn the_gradient_is_that_of_the_loss() {
    let shape = Shape { hidden: 16, layers: 2 };
    let (warm_up, horizon) = (4, 5);
    let numbers = shape.random(3);
    let data = samples(3, warm_up + horizon);
    let network = Network::<f64>::new(shape, &numbers);
    let mut before = Tape::new(&network, 3, warm_up, horizon);
    let rest: Vec<Window<'_, f64>> = data.iter().map(|s| Window { samples: s }).collect();
    before.run(&network, Begin::Rest, &rest, None);
    let onward: Vec<Window<'_, f64>> =
        data.iter().map(|s| Window { samples: &s[..=horizon] }).collect();
    for (begin, windows) in [(Begin::Rest, &rest), (Begin::Carried, &onward)] {
        let loss = |numbers: &[f64]| {
            let network = Network::<f64>::new(shape, numbers);
            before.clone().run(&network, begin, windows, None)
        };
        let mut gradient = vec![0.0; shape.len()];
        let value = before.clone().run(&network, begin, windows, Some(&mut gradient));
        assert_eq!(value, loss(&numbers));
        for part in shape.parts() {
            for k in [0, part.range.len() / 3, part.range.len() / 2, part.range.len() - 1] {
                let at = part.range.start + k;
                let h = 1e-5;
                let mut up = numbers.clone();
                up[at] += h;
                let mut down = numbers.clone();
                down[at] -= h;
                let difference = (loss(&up) - loss(&down)) / (2.0 * h);
                // Rounding error of the difference of the two losses.
                let rounding = 4.0 * f64::EPSILON * value / h;
                assert!(
                    (gradient[at] - difference).abs() < 1e-6 * difference.abs() + rounding,
                    "{} {k}: {} {difference}",
                    part.name,
                    gradient[at]
                );
            }
        }
    }
}

/// Two pieces of a run have the loss of the whole.
#[test]
fn pieces_are_the_whole() {
    let shape = Shape { hidden: 16, layers: 2 };
    let network = Network::<f64>::new(shape, &shape.random(4));
    let data = samples(3, 14);
    let part = |range: std::ops::Range<usize>| -> Vec<Window<'_, f64>> {
        data.iter().map(|s| Window { samples: &s[range.clone()] }).collect()
    };
    let whole = Tape::new(&network, 3, 4, 10).run(&network, Begin::Rest, &part(0..14), None);
    let mut tape = Tape::new(&network, 3, 4, 5);
    let first = tape.run(&network, Begin::Rest, &part(0..9), None);
    let second = tape.run(&network, Begin::Carried, &part(8..14), None);
    assert!((first + second - whole).abs() < 1e-12 * whole, "{first} {second} {whole}");
}

/// A block of fewer windows than the batch holds, after a fuller one, is as good as new.
#[test]
fn memory_leaves_no_trace() {
    let shape = Shape { hidden: 16, layers: 2 };
    let network = Network::<f32>::new(shape, &shape.random(5));
    let narrow = |s: &Vec<[f64; INPUTS]>| -> Vec<[f32; INPUTS]> {
        s.iter().map(|v| v.map(|v| v as f32)).collect()
    };
    let data: Vec<_> = samples(3, 9).iter().map(narrow).collect();
    let windows: Vec<Window<'_, f32>> = data.iter().map(|s| Window { samples: s }).collect();
    let run = |tape: &mut Tape<f32>, windows: &[Window<'_, f32>]| {
        let mut gradient = vec![0.0; shape.len()];
        let loss = tape.run(&network, Begin::Rest, windows, Some(&mut gradient));
        (loss, gradient)
    };
    let fresh = run(&mut Tape::new(&network, 3, 4, 5), &windows[1..2]);
    let mut used = Tape::new(&network, 3, 4, 5);
    run(&mut used, &windows);
    assert_eq!(run(&mut used, &windows[1..2]), fresh);
}
