//! The published network, and its runs by an adaptive solver of fifth order.

use super::joint::{DT, Joint, driven};
use pam_core::SealedMasses;
use pam_data::Subject;
use pam_data::{MassOrigin, Recording, load_model};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{SolverSettings, StepChoice, predict};
use std::f64::consts::TAU;
use std::path::Path;

/// The published weights.
pub(crate) fn weights() -> Joint {
    let path = "../data/published/hybrid_model_puresine_16.eqx";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    load_model(&path).expect("the published weights").model
}

/// The published solver settings at a tolerance that leaves no error to speak of.
pub(crate) fn exact() -> SolverSettings {
    SolverSettings {
        tableau: Tableau::tsit5(),
        step: StepChoice::Adaptive { rtol: 1e-8, atol: 1e-8 },
        interpolation: Interpolation::Hold,
    }
}

/// Half, one and two hertz at two amplitudes, as in the published excitation, `share` of its 70 s; N.
pub(crate) fn paper_force_n(share: f64) -> impl Fn(f64) -> f64 {
    let parts: Vec<(f64, f64, f64)> = [(0.5, 20.0), (1.0, 10.0), (2.0, 5.0)]
        .iter()
        .flat_map(|&(hertz, s)| [133.5, 200.3].map(|a| (hertz, a, s * share)))
        .collect();
    move |t| {
        let mut from = 0.0;
        for &(hertz, amplitude, s) in &parts {
            if t < from + s {
                return amplitude * (TAU * hertz * (t - from)).sin();
            }
            from += s;
        }
        0.0
    }
}

/// What the model itself does under the published excitation, solved exactly, from rest at gauge pressures
/// (psi).
pub(crate) fn exact_run(model: &Joint, psi: [f64; 2], share: f64) -> Subject {
    run_with(model, psi, share, &exact())
}

/// The same with other solver settings.
pub(crate) fn run_with(
    model: &Joint,
    psi: [f64; 2],
    share: f64,
    settings: &SolverSettings,
) -> Subject {
    let kpa = psi.map(|p| p * 6.894_76 + 101.325);
    // Rest: the masses at the commanded pressures and the place where they hold the joint, in turn.
    let mut x = 0.0;
    let mut masses = model.gas_law_masses(x, kpa);
    for _ in 0..30 {
        x = rest(model, masses);
        masses = model.gas_law_masses(x, kpa);
    }
    let mut command = driven(70.0 * share - DT, x, paper_force_n(share));
    command.pressure_flexor_kpa.fill(kpa[0]);
    command.pressure_extensor_kpa.fill(kpa[1]);
    let run = predict(model, &command, masses, settings).expect("the published model runs");
    let recording: Recording = run.to_recording(&command, masses);
    Subject { recording, masses, origin: MassOrigin::Given }
}

fn rest(model: &Joint, masses: SealedMasses) -> f64 {
    use pam_core::{ForceInput, ForceModel};
    let mut work = vec![0.0; model.force.work_len()];
    let (mut low, mut high) = (-8.0, 8.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let at = ForceInput {
            displacement_mm: middle,
            velocity_mm_s: 0.0,
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
        };
        if model.force.restoring_force_mn(&at, &mut work) > 0.0 {
            high = middle
        } else {
            low = middle
        }
    }
    0.5 * (low + high)
}
