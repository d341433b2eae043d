#![allow(dead_code)]
#[path = "../../tests/src/plant/mod.rs"]
mod plant;
use plant::*;
use pam_data::*;
use pam_diagnose::*;
use pam_effects::ExtendedModel;
use rayon::prelude::*;
use std::time::Instant;

fn laws() -> Vec<(&'static str, Vec<Hidden>)> {
    let h = |id: &str, v: &[(&str, f64)]| vec![Hidden::new(id, v)];
    vec![
        ("cubic_spring", h("cubic_spring", &[("n_mm3", 6.0)])),
        ("quadratic_drag", h("quadratic_drag", &[("n_s2_mm2", 0.25)])),
        ("pressure_damping", h("pressure_damping", &[("n_s_mm_kpa", 0.003)])),
        ("displacement_damping", h("displacement_damping", &[("n_s_mm3", 4.0)])),
        ("one_way_damping", h("one_way_damping", &[("n_s_mm", 2.0)])),
        ("soft_stop", h("soft_stop", &[("n_mm", 25.0), ("from_mm", 0.5)])),
        ("flexor_friction", h("flexor_friction", &[("n_kpa", 0.05)])),
        ("crosstalk", h("chamber_crosstalk", &[("rate_per_s", 4e-3)])),
        ("second_path", h("second_path", &[("share", 0.15), ("time_s", 0.4)])),
        ("warming_damping", h("warming_damping", &[("n_s3_mm3", 0.03), ("time_s", 2.0)])),
        ("reading_crosstalk", h("reading_crosstalk", &[("share", 0.1)])),
        ("pressure_friction", h("pressure_friction", &[("n_kpa", 0.05)])),
        ("null", vec![]),
    ]
}

fn cpu() -> f64 {
    std::fs::read_dir("/proc/self/task").unwrap().flatten().filter_map(|t| std::fs::read_to_string(t.path().join("schedstat")).ok()?.split_whitespace().next()?.parse::<f64>().ok()).sum::<f64>() * 1e-9
}

fn main() {
    let arg: Vec<String> = std::env::args().collect();
    let saved = load_model("data/published/hybrid_model_puresine_16.eqx").unwrap();
    let plant = Plant::of(&saved.model);
    let psi: Vec<[f64; 2]> = vec![[30.0, 60.0], [45.0, 70.0], [60.0, 35.0], [50.0, 25.0], [35.0, 40.0], [65.0, 65.0]];
    let count: usize = arg.get(2).map_or(3, |s| s.parse().unwrap());
    for (name, effects) in laws() {
        if arg.get(1).is_some_and(|a| a != "all" && a != name) { continue; }
        let clock = Instant::now();
        let sensors = Sensors::default();
        let data: Vec<Subject> = (0..count).into_par_iter().map(|i| {
            let e = Excitation::published(20.0 / 70.0);
            let n = format!("nn_{:.0}{:.0}", psi[i][0], psi[i][1]);
            let run = Experiment::new(&n, psi[i], &e, &effects, &sensors, 100 + i as u64);
            let r = plant.record(&run);
            let masses = plant::masses(&saved.model, &r);
            Subject { recording: r, masses, origin: MassOrigin::GasLaw }
        }).collect();
        eprintln!("== {name}: data {:.2} s", clock.elapsed().as_secs_f64());
        let model = ExtendedModel::from_saved(saved.clone()).unwrap();
        let options = DiagnoseOptions::default();
        let sets = RecordingSets { data: &data, test: None, baseline: None };
        let clock = Instant::now();
        let found = diagnose(&model, &sets, &options, &|_, _| {}).unwrap();
        println!("{name}: {} {:?} reduction {:.3} x {:.4} -> {:.4} any {:.2} named {:.2}  ({:.1} s)", found.verdict, found.named(),
            found.error_reduction.overall.error_reduction, found.error_reduction.channels[0].rmse_before, found.error_reduction.channels[0].rmse_after,
            found.explainable.any_correction, found.explainable.named, clock.elapsed().as_secs_f64());
        for r in &found.reasons { println!("     {r}"); }
        if arg.get(3).is_some_and(|a| a == "x") { continue; }
        let clock = Instant::now();
        let found = learn_remainder(&model, &sets, &options, found, &|s| eprintln!("    {s:.2} {:.1}", cpu())).unwrap();
        let r = found.remainder.as_ref().unwrap();
        println!("   {} in {:.1} s; {} {}", r.outcome, clock.elapsed().as_secs_f64(), found.verdict, r.sentence);
        if let Some(c) = &r.correction {
            println!("   correction {:?} validation {:.3} p {:.1e} test {:.3?} confirmed {} ", c.acts, c.validation_share, c.p_value, c.error_reduction.overall, c.confirmed);
            println!("   depends {}", c.depends_on.iter().map(|d| format!("{} {:.3} [{:.3} {:.3}] p {:.1e}", d.on, d.error_ratio, d.ci95[0], d.ci95[1], d.p_value)).collect::<Vec<_>>().join("; "));
        }
        if let Some(l) = &r.law {
            println!("   LAW {} vars {:?} beside {:?} share {:.3} similarity {:.3} complete {} test {:.4?}", l.expression, l.variables, l.beside, l.share_of_correction, l.similarity, l.is_complete(), l.error_reduction.overall);
            for (n, i) in &l.parameters { println!("      {n} {:.5} [{:.5}, {:.5}]", i.value, i.ci95[0], i.ci95[1]); }
        }
        if arg.get(4).is_some() || r.law.is_none() { for t in &r.ranking { println!("      rank {:.1} {} beside {:?} len {:.1} val {:.3}", t.log_odds, t.expression, t.beside, t.description_length, t.validation); } }
        println!("   extended: {}", found.model.extended.describe_effects().chars().take(200).collect::<String>());
    }
}
