//! The batched motion of the sealed joint against the generic field.

use num_dual::Dual64;
use pam_autodiff::BatchField;
use pam_autodiff::batch::sealed_motion::{DAMPING, MASS};
use pam_autodiff::batch::{ParameterSums, Points, SealedMotion};
use pam_core::force::{Dense, Mlp};
use pam_core::{
    Activation, JointModel, NetworkForce, ParametricField, Scalar, SealedMasses, VectorField,
};

fn model() -> JointModel<f64, NetworkForce<f64>> {
    let layer = |inputs: usize, outputs: usize, seed: f64, scale: f64| {
        let value = |k: usize| scale * (seed + k as f64 * 1.313).sin();
        let weights: Vec<f64> = (0..inputs * outputs).map(value).collect();
        Dense::from_rows(&weights, (0..outputs).map(|k| value(k + 99)).collect()).unwrap()
    };
    let layers = vec![layer(4, 20, 0.3, 1.0), layer(20, 12, 1.1, 0.4), layer(12, 1, 2.2, 3e3)];
    let activation = Activation::from_name("leaky_relu").unwrap();
    let force = NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap();
    let mut model = JointModel::datasheet(force);
    model.auxiliary_damping_kg_s = 700.0;
    model
}

/// Jacobians and parameter cotangents equal those of the generic field by dual numbers.
#[test]
fn equals_the_generic_field() {
    let model = model();
    let masses = SealedMasses::new(0.05, 0.09).unwrap();
    let field = model.sealed(masses);
    let motion = SealedMotion::<f64>::new(&model, &model.force);
    let condition = motion.condition(masses);
    let points = 7;
    let number = |seed: f64, k: usize| (seed + 0.77 * k as f64).sin();
    let t = vec![0.0; points];
    let y: Vec<f64> = (0..2 * points).map(|k| 2.0 * number(0.1, k)).collect();
    let u: Vec<f64> = (0..points).map(|k| 1e5 * number(0.5, k)).collect();
    let w: Vec<f64> = (0..2 * points).map(|k| number(0.9, k)).collect();

    let mut batch = motion.batch(points);
    (0..points).for_each(|k| motion.set_condition(k, &condition, &mut batch));
    let mut dy = vec![0.0; 2 * points];
    let mut kept = vec![0.0; points * motion.kept_len()];
    let at = Points { t: &t, y: &y, u: &u };
    motion.eval_batch(at, &mut dy, &mut kept, &mut batch);
    let mut jacobians = vec![0.0; 4 * points];
    let mut block = motion.block(points);
    motion.linearise(&condition, at, &kept, &mut jacobians, &mut block);
    let mut shared = vec![0.0; motion.parameter_len()];
    let mut own = vec![0.0; 2];
    let mut sums = ParameterSums { shared: &mut shared, own: &mut own };
    motion.accumulate(&condition, at, &kept, &w, &mut sums, &mut block);
    motion.drain(&condition, &mut sums, &mut block);

    let parameters = field.parameters();
    let lift = |p: &[f64]| p.iter().map(|&v| Dual64::constant(v)).collect::<Vec<_>>();
    let evaluate = |parameters: &[Dual64], state: [Dual64; 2], force: f64| {
        let field = field.with_parameters(parameters);
        let mut out = [Dual64::constant(0.0); 4];
        let mut work = vec![Dual64::constant(0.0); VectorField::<Dual64>::work_len(&field)];
        let y = [state[0], state[1], Dual64::constant(400.0), Dual64::constant(400.0)];
        field.eval_into(0.0, &y, &[Dual64::constant(force)], &mut out, &mut work);
        [out[0], out[1]]
    };
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-11 * (1e-3 + a.abs().max(b.abs()));
    for p in 0..points {
        for column in 0..2 {
            let mut state = [Dual64::constant(y[2 * p]), Dual64::constant(y[2 * p + 1])];
            state[column].eps = 1.0;
            let exact = evaluate(&lift(&parameters), state, u[p]);
            for row in 0..2 {
                assert!(close(jacobians[4 * p + 2 * row + column], exact[row].eps));
                assert!(close(dy[2 * p + row], exact[row].re));
            }
        }
    }
    let network_len = shared.len() - 2;
    let softplus_slope = model.raw.mass.sigmoid();
    for (i, _) in parameters.iter().enumerate() {
        let mut lifted = lift(&parameters);
        lifted[i].eps = 1.0;
        let exact: f64 = (0..points)
            .map(|p| {
                let state = [Dual64::constant(y[2 * p]), Dual64::constant(y[2 * p + 1])];
                let d = evaluate(&lifted, state, u[p]);
                d[0].eps * w[2 * p] + d[1].eps * w[2 * p + 1]
            })
            .sum();
        let ours = match i - i.min(network_len) {
            _ if i < network_len => shared[i],
            0 => shared[network_len + MASS] * softplus_slope,
            1 | 2 => 0.0, // C and ν do not act on the motion
            3 => shared[network_len + DAMPING],
            k => own[k - 4],
        };
        assert!(close(ours, exact), "parameter {i}: {ours} {exact}");
    }
}
