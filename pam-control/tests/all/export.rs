//! Exported tables and networks against the plan and the model that they come from.

use crate::common::published;
use approx::assert_relative_eq;
use pam_control::export::{Precision, c_header, network_bytes, row, table_bytes, table_csv};
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::synthesis::{MassBounds, Plan, SynthesisSettings, plan::targets};
use pam_core::{Activation, AnyForce, ForceInput, ForceModel, JointModel, Mlp, NetworkForce};
use pam_embedded::{Network, NetworkError, Table};

fn plan(model: &JointModel<f64, AnyForce<f64>>) -> Plan {
    let motion = MotionSpec::parse("sine:A=1,f=0.5").unwrap();
    let stiffness = StiffnessProfile::parse("150").unwrap();
    let targets = targets(&motion, Some(&stiffness), 0.0, 200.0).unwrap();
    Plan::new(model, targets, SynthesisSettings::published(MassBounds::trained(model))).unwrap()
}

fn points() -> impl Iterator<Item = [f64; 4]> {
    (0..500).map(|k| {
        let r = |seed: f64| (0.5 + 0.5 * (seed * f64::from(k) + seed).sin()).clamp(0.0, 1.0);
        [0.03 + 0.09 * r(1.1), 0.03 + 0.09 * r(2.3), 6.0 * r(3.7) - 3.0, 20.0 * r(5.9) - 10.0]
    })
}

fn force(model: &NetworkForce<f64>, [m_f, m_e, x, v]: [f64; 4]) -> f64 {
    let input = ForceInput {
        displacement_mm: x,
        velocity_mm_s: v,
        mass_flexor_g: m_f,
        mass_extensor_g: m_e,
    };
    model.restoring_force_mn(&input, &mut vec![0.0; ForceModel::<f64>::work_len(model)])
}

#[test]
fn the_small_evaluator_matches_the_model() {
    let model = published();
    let AnyForce::Network(network) = &model.force else { panic!("a network") };
    for name in Activation::NAMES {
        let activation = Activation::from_name(name).unwrap();
        let mlp = Mlp::new(network.mlp().layers().to_vec(), activation).unwrap();
        let network = NetworkForce::new(mlp).unwrap();
        let doubles = network_bytes(&model, &network, Precision::F64).unwrap();
        let singles = network_bytes(&model, &network, Precision::F32).unwrap();
        let small = Network::<f64>::new(&doubles).unwrap();
        let single = Network::<f32>::new(&singles).unwrap();
        let mut work = vec![0.0; small.work_len()];
        let mut single_work = vec![0.0; single.work_len()];
        let largest = points().map(|p| force(&network, p).abs()).fold(0.0, f64::max);
        for p in points() {
            let full = force(&network, p);
            let found = small.force_mn(p, &mut work).unwrap();
            assert!((found - full).abs() <= 1e-6 + 1e-12 * full.abs(), "{name}: {found} {full}");
            let found = single.force_mn(p.map(|v| v as f32), &mut single_work).unwrap();
            let miss = (f64::from(found) - full).abs();
            // These weights were trained with leaky ReLU; other activations amplify rounding.
            assert!(
                name != &"leaky_relu" || miss <= 1e-6 * largest,
                "{name}: {miss} of {largest} mN in single precision"
            );
        }
    }
}

#[test]
fn the_joints_numbers_are_the_models() {
    let model = published();
    let AnyForce::Network(network) = &model.force else { panic!("a network") };
    let bytes = network_bytes(&model, network, Precision::F32).unwrap();
    let small = Network::<f32>::new(&bytes).unwrap();
    for x in [-2.0, 0.0, 1.3] {
        let masses = model.gas_law_masses(x, [300.0, 500.0]);
        let found = small.joint().pressures_kpa(x, [masses.flexor_g, masses.extensor_g]);
        assert_relative_eq!(found[0], 300.0, max_relative = 1e-12);
        assert_relative_eq!(found[1], 500.0, max_relative = 1e-12);
        assert_relative_eq!(
            small.joint().masses_g(x, [300.0, 500.0])[0],
            masses.flexor_g,
            max_relative = 1e-12
        );
    }
}

#[test]
fn damaged_networks_are_refused() {
    let model = published();
    let AnyForce::Network(network) = &model.force else { panic!("a network") };
    let bytes = network_bytes(&model, network, Precision::F32).unwrap();
    assert_eq!(Network::<f64>::new(&bytes).err(), Some(NetworkError::Size));
    for len in [0, 3, 19, 60, 80, bytes.len() - 1] {
        assert!(Network::<f32>::new(&bytes[..len]).is_err(), "{len} bytes");
    }
    let mut other = bytes.clone();
    other[68] = 5;
    assert_eq!(Network::<f32>::new(&other).err(), Some(NetworkError::Shape));
}

#[test]
fn the_binary_table_is_the_plan() {
    let plan = plan(&published());
    let bytes = table_bytes(&plan);
    let table = Table::new(&bytes).unwrap();
    assert_eq!(table.rows(), plan.targets.len());
    for sample in 0..table.rows() {
        let time = plan.targets[sample].time_s;
        let [f, e] = table.pressures_kpa(time).unwrap();
        let wanted = plan.pressures_kpa[sample];
        assert_relative_eq!(f64::from(f), wanted[0], max_relative = 1e-6);
        assert_relative_eq!(f64::from(e), wanted[1], max_relative = 1e-6);
    }
    let middle = f64::from(table.value(6, 0.5 * (plan.targets[3].time_s + plan.targets[4].time_s)));
    let mean = 0.5 * (plan.pressures_kpa[3][0] + plan.pressures_kpa[4][0]);
    assert_relative_eq!(middle, mean, max_relative = 1e-6);
    assert!(Table::new(&bytes[..bytes.len() - 1]).is_err());
}

/// The C header, compiled with the system's compiler, reads the same numbers.
#[test]
fn the_c_header_reads_the_same_numbers() {
    let plan = plan(&published());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("table.h"), c_header(&plan)).unwrap();
    let program = "#include <stdio.h>\n#include \"table.h\"\nint main(void) {\n\
        for (int k = -3; k < 700; k++) printf(\"%.9g %.9g\\n\", \
        pam_table_at(PAM_PRESSURE_FLEXOR_KPA, k * 0.0111f), \
        pam_table_at(PAM_MASS_EXTENSOR_G, k * 0.0111f));\nreturn 0;\n}\n";
    std::fs::write(folder.path().join("main.c"), program).unwrap();
    let binary = folder.path().join("main");
    let compiled = std::process::Command::new("cc")
        .args(["-std=c99", "-Wall", "-Werror", "-o"])
        .args([&binary, &folder.path().join("main.c")])
        .status()
        .expect("a C compiler");
    assert!(compiled.success());
    let out = std::process::Command::new(&binary).output().unwrap();
    let bytes = table_bytes(&plan);
    let table = Table::new(&bytes).unwrap();
    for (line, k) in String::from_utf8(out.stdout).unwrap().lines().zip(-3..) {
        let time = f64::from(k as f32 * 0.0111_f32);
        let found: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
        assert_relative_eq!(found[0], f64::from(table.value(6, time)), max_relative = 1e-5);
        assert_relative_eq!(found[1], f64::from(table.value(5, time)), max_relative = 1e-5);
    }
}

#[test]
fn the_csv_table_keeps_all_digits() {
    let plan = plan(&published());
    let text = table_csv(&plan);
    let line = text.lines().nth(12).unwrap();
    let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
    assert_eq!(&cells[1..9], row(&plan, 11));
    assert_eq!(text.lines().count(), plan.targets.len() + 1);
}
