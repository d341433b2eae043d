//! Time of a decision of the receding-horizon controller, on one core: every millisecond of a second-long closed loop over
//! the model itself, horizon 120 ms.

use pam_bench::published_model;
use pam_control::execution::Reading;
use pam_control::mpc::{MpcController, MpcSettings, Reference};
use pam_control::synthesis::MassBounds;
use std::time::Instant;

fn main() {
    let model = published_model();
    let bounds = MassBounds::trained(&model);
    let reading = |k: usize| Reading {
        displacement_mm: 0.05 * (0.013 * k as f64).sin(),
        pressures_kpa: [300.0, 300.0 + 2.0 * (0.01 * k as f64).sin()],
    };
    let settings = MpcSettings::default();
    let mut controller =
        MpcController::new(&model, settings, bounds, &reading(0)).expect("settings are right");
    let mut times: Vec<f64> = (0..20_000)
        .map(|k| {
            let reading = reading(k);
            let begin = Instant::now();
            controller.tick(&reading, |ahead| Reference {
                displacement_mm: (0.6 * (1e-3 * k as f64 + ahead)).sin(),
                velocity_mm_s: 0.6 * (0.6 * (1e-3 * k as f64 + ahead)).cos(),
                total_g: 0.12,
            });
            1e6 * begin.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
    let horizon_ms = 1e3 * settings.horizon.steps as f64 * settings.horizon.step_s;
    println!(
        "a decision, horizon {horizon_ms:.0} ms, {} flows: median {:.1} µs, p99 {:.1} µs, p99.9 {:.1} µs",
        2 * settings.horizon.steps,
        at(0.5),
        at(0.99),
        at(0.999)
    );
}
