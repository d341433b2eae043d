use pam_data::*; use pam_train::*; use pam_diagnose::{effects, simulation::*, fit::*, search::*};
use pam_tests::plant::{self, *};
use std::time::Instant;
fn main() {
    let saved = load_model(&pam_tests::published_weights()).unwrap();
    let all: Vec<(&str, Vec<(&str, f64)>)> = vec![
        ("none", vec![]),
        ("coulomb_friction", vec![("force_n", 15.0)]),
        ("stribeck_friction", vec![("coulomb_n", 10.0), ("static_n", 25.0), ("velocity_mm_s", 2.0)]),
        ("viscous_damping", vec![("coefficient_ns_m", 1000.0)]),
        ("hysteresis", vec![("force_n", 15.0), ("slip_mm", 0.5)]),
        ("creep", vec![("stiffness_n_mm", 10.0), ("time_constant_s", 3.0)]),
        ("constant_load", vec![("force_n", 15.0)]),
        ("added_inertia", vec![("mass_kg", 40.0)]),
        ("backlash", vec![("gap_mm", 0.1)]),
        ("cogging", vec![("force_n", 8.0), ("pitch_mm", 0.6)]),
        ("tendon_slack", vec![("displacement_mm", 0.9), ("stiffness_loss", 0.3)]),
        ("stiffness_drift", vec![("relative_per_min", 0.15)]),
        ("stiffness_scale", vec![("relative", 0.08)]),
        ("leak", vec![("flexor_rate_per_s", 2e-3), ("extensor_rate_per_s", 1e-3)]),
        ("polytropic_gas", vec![("exponent", 1.2)]),
        ("geometry_coefficient", vec![("relative", 0.08)]),
        ("force_gain", vec![("relative", -0.08)]),
        ("force_saturation", vec![("force_n", 160.0)]),
        ("actuation_delay", vec![("delay_ms", 12.0)]),
        ("pressure_sensor_lag", vec![("cutoff_hz", 5.0)]),
        ("pressure_delay", vec![("delay_ms", 30.0)]),
        ("pressure_bias", vec![("flexor_kpa", 12.0), ("extensor_kpa", -8.0)]),
        ("pressure_gain", vec![("flexor_relative", 0.05), ("extensor_relative", -0.04)]),
        ("position_offset", vec![("offset_mm", 0.15)]),
        ("position_gain", vec![("relative", 0.05)]),
        ("periodic_disturbance", vec![("force_n", 12.0), ("frequency_hz", 1.37)]),
        ("gain_jump", vec![("time_s", 12.0), ("relative", 0.06)]),
        ("crosstalk", vec![("rate_per_s", 4e-3)]),
        ("offset_jump", vec![("time_s", 14.0), ("slip_mm", 0.4)]),
    ];
    let only: Vec<String> = std::env::args().skip(1).collect();
    let conditions = [[45.0, 45.0], [30.0, 60.0], [70.0, 60.0]];
    for (id, p) in all {
        if !only.is_empty() && !only.iter().any(|o| o == id) { continue }
        let h = [hidden(id, &p)];
        use rayon::prelude::*;
        let subjects: Vec<Subject> = conditions.par_iter().enumerate().map(|(i, &psi)| {
            let r = plant::record(&saved.model, &format!("nn_{}{}", psi[0], psi[1]), psi, &excitation(0.4), if id == "none" { &[] } else { &h }, Noise::default(), 7 + i as u64);
            let masses = plant::masses(&saved.model, &r);
            Subject { recording: r, masses, origin: MassOrigin::GasLaw }
        }).collect();
        let t = Instant::now();
        let trials: Vec<Trial> = subjects.iter().map(|s| Trial::new(&saved.model, s)).collect();
        let all: Vec<&Trial> = trials.iter().collect();
        let base = Base::of(&saved.model);
        let floors = noise_floors(&all);
        let split = Split { train: Problem::new(trials[..2].iter(), base, 0.5, floors), held: Problem::new(trials[2..].iter(), base, 0.5, floors), same_trials: false };
        let search = Search { evidence: gather(&all[..2], &base), split, candidates: effects::ALL.to_vec() };
        let t1 = t.elapsed();
        let b = search.base(&[]).unwrap();
        let s = search.extend(&b.fit.hypothesis, 24);
        println!("{id} {p:?} floors {:?}  setup {t1:.1?} all {:.1?}", floors.0, t.elapsed());
        let rms = |e: &ChannelErrors| e.mean().map(|m| (m.sqrt() * 1e4).round() / 1e4);
        println!("   base: rms {:?} held {:?} total {:.0}", rms(&b.fit.errors), rms(&b.held), b.total);
        for s in s.iter().take(4) {
            let iv = search.split.train.intervals(&s.fit).unwrap();
            let iv: Vec<String> = iv.iter().map(|i| format!("{:.4}[{:.4},{:.4}]", i.value, i.ci95[0], i.ci95[1])).collect();
            println!("   {:?} {:?} {} held {:?} total {:.0} lim {:?} lm {:?}", s.fit.hypothesis.ids(), s.fit.hypothesis.values, iv.join(" "), rms(&s.held), s.total, s.fit.at_limit, s.fit.hypothesis.log_model.map(|v| (v*1e5).round()/1e5));
        }
    }
}
