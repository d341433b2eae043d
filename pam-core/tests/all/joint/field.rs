use approx::assert_relative_eq;
use num_dual::Dual64;
use pam_core::Scalar;
use pam_core::VectorField;
use pam_core::joint::{ME, MF, PE, PF, V};
use pam_core::{JointModel, SealedMasses, SpringDamper};

fn model() -> JointModel<f64, SpringDamper<f64>> {
    let mut model = JointModel::datasheet(SpringDamper::constant(150e3, 6000.0));
    model.auxiliary_damping_kg_s = 500.0;
    model
}

fn masses() -> SealedMasses {
    SealedMasses::new(0.06, 0.08).unwrap()
}

#[test]
fn the_learned_force_restores() {
    let model = model();
    let field = model.sealed(masses());
    let mut dy = [0.0; 4];
    field.eval_into(0.0, &[1.0, 0.0, 300.0, 300.0], &[0.0], &mut dy, &mut []);
    assert!(dy[V] < 0.0, "a displaced joint is pulled back");
    assert_relative_eq!(dy[V], -150e3 / model.physical().mass_kg, max_relative = 1e-14);
    field.eval_into(0.0, &[0.0, 2.0, 300.0, 300.0], &[7.0e3], &mut dy, &mut []);
    let expected = (7.0e3 - 6500.0 * 2.0) / model.physical().mass_kg;
    assert_relative_eq!(dy[V], expected, max_relative = 1e-14);
}

#[test]
fn pressure_rates_are_the_time_derivative_of_the_gas_law() {
    let model = model();
    let (x, v) = (0.8, -3.0);
    let [pf, pe] = model.gas_law_pressures_kpa(x, masses());
    let mut dy = [0.0; 4];
    model.sealed(masses()).eval_into(0.0, &[x, v, pf, pe], &[0.0], &mut dy, &mut []);
    let lifted = model.map(Dual64::constant, |f| f.map(Dual64::constant));
    let along = lifted.gas_law_pressures_kpa(Dual64::new(x, v), masses().lift());
    assert_relative_eq!(dy[PF], along[0].eps, max_relative = 1e-12);
    assert_relative_eq!(dy[PE], along[1].eps, max_relative = 1e-12);
}

#[test]
fn open_valves_add_the_flow_terms() {
    let model = model();
    let (x, v) = (0.3, 1.5);
    let m = masses();
    let [pf, pe] = model.gas_law_pressures_kpa(x, m);
    let y = [x, v, pf, pe, m.flexor_g, m.extensor_g];
    let flows = [0.02, -0.01];
    let mut open = [0.0; 6];
    let field = model.with_open_valves();
    field.eval_into(0.0, &y, &[100.0, flows[0], flows[1]], &mut open, &mut []);
    // d/dt (C m / V) along x + v t, m + ṁ t.
    let lifted = model.map(Dual64::constant, |f| f.map(Dual64::constant));
    let along = lifted.gas_law_pressures_kpa(
        Dual64::new(x, v),
        SealedMasses {
            flexor_g: Dual64::new(m.flexor_g, flows[0]),
            extensor_g: Dual64::new(m.extensor_g, flows[1]),
        },
    );
    assert_relative_eq!(open[PF], along[0].eps, max_relative = 1e-12);
    assert_relative_eq!(open[PE], along[1].eps, max_relative = 1e-12);
    assert_eq!([open[MF], open[ME]], flows);
}
