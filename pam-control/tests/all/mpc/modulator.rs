use pam_control::execution::{SAMPLE_S, Valve};
use pam_control::mpc::ValveModel;
use pam_control::mpc::modulator::Modulator;

/// The mean flow is the wanted one, and openings are no shorter than they may be.
#[test]
fn the_mean_flow_is_the_wanted_one() {
    let valves = ValveModel::default();
    for wanted in [0.01, 0.05, -0.03] {
        let mut modulator = Modulator::default();
        let (mut sum, mut open, mut shortest) = (0.0, 0, usize::MAX);
        for _ in 0..4000 {
            let (valve, flow) = modulator.decide(wanted, 400.0, &valves);
            sum += flow * SAMPLE_S;
            if valve == Valve::Shut {
                if open > 0 {
                    shortest = shortest.min(open);
                }
                open = 0;
            } else {
                open += 1;
            }
        }
        assert!((sum - 4.0 * wanted).abs() < 1e-3, "{sum} g for {wanted} g/s");
        assert!(shortest >= 3, "an opening of {shortest} ms");
    }
}
