use approx::assert_relative_eq;
use pam_core::Mlp;
use pam_core::activation::{LeakyRelu, Tanh};
use pam_core::force::Dense;

fn two_layers() -> Vec<Dense<f64>> {
    vec![
        Dense::from_rows(&[1.0, 2.0, -1.0, 0.5, 0.0, 3.0], vec![0.1, -0.2, 0.3]).unwrap(),
        Dense::from_rows(&[2.0, -1.0, 0.5], vec![1.0]).unwrap(),
    ]
}

#[test]
fn forward_is_the_textbook_formula() {
    let mlp = Mlp::new(two_layers(), Tanh).unwrap();
    let (x, y) = (0.3_f64, -0.7_f64);
    let hidden = [(x + 2.0 * y + 0.1).tanh(), (-x + 0.5 * y - 0.2).tanh(), (3.0 * y + 0.3).tanh()];
    let expected = 2.0 * hidden[0] - hidden[1] + 0.5 * hidden[2] + 1.0;
    let mut out = [0.0];
    let mut work = vec![f64::NAN; mlp.work_len()];
    mlp.forward_into(&[x, y], &mut out, &mut work);
    assert_relative_eq!(out[0], expected, max_relative = 1e-14);
}

#[test]
fn rows_survive_the_round_trip() {
    let rows: Vec<f64> = (0..12).map(f64::from).collect();
    let layer = Dense::from_rows(&rows, vec![0.0; 3]).unwrap();
    assert_eq!((layer.outputs(), layer.inputs()), (3, 4));
    assert_eq!(layer.weight_rows(), rows);
}

#[test]
fn layers_that_do_not_chain_are_refused() {
    let mut layers = two_layers();
    layers.swap(0, 1);
    let message = Mlp::new(layers, LeakyRelu::default()).unwrap_err().to_string();
    assert!(message.contains("layer 0"), "{message}");
    assert!(Dense::from_rows(&[1.0, 2.0, 3.0], vec![0.0, 0.0]).is_err());
    assert!(Mlp::<f64, _>::new(vec![], Tanh).is_err());
}
