use pam_cli::rig_joint::RigJoint;
use pam_control::execution::*; use pam_control::experiments::*; use pam_control::synthesis::*; use pam_control::equilibrium_point::*; use pam_control::statistics::*;
use pam_rig::RigParameters; use std::time::Instant;
fn main() {
    let a: Vec<f64> = std::env::args().skip(1).map(|v| v.parse().unwrap()).collect();
    let model = pam_data::load_model(std::path::Path::new("pam-cli/models/default.safetensors")).unwrap().model;
    let m = model.physical().mass_kg;
    let s = SynthesisSettings::published(MassBounds::trained(&model));
    let params = RigParameters::default();
    let make = move |seed: u64, p: [f64;2]| -> Box<dyn Joint> { Box::new(RigJoint::new(&params, seed, p).unwrap()) };
    let shape = PulseShape { window_s: a[0], force_n: a[1], before_s: a[2], ..Default::default() };
    let t0 = Instant::now();
    let plan = Plan::new(&model, stiffness::staircase_targets(&stiffness::STAIRCASE_N_MM).unwrap(), s).unwrap();
    println!("plan {:?}", t0.elapsed());
    let r = stiffness::staircase(&Commands::from(&plan), 6, &shape, m, 1, &make).unwrap();
    for l in stiffness::STAIRCASE_N_MM { let k: Vec<f64> = r.iter().filter(|i| i.record.commanded_n_mm == l).map(|i| i.estimate.stiffness_n_mm).collect(); let pk: Vec<f64> = r.iter().filter(|i| i.record.commanded_n_mm == l).map(|i| i.estimate.peak_mm).collect(); println!("stair {l} {:.1?} peak {:.3?}", mean_and_deviation(&k), mean_and_deviation(&pk)); }
    let t0 = Instant::now();
    let t = comparison::targets().unwrap();
    let plan = Plan::new(&model, t.clone(), s).unwrap();
    println!("plan {:?}", t0.elapsed());
    let (rows, all) = comparison::rows(&Commands::from(&plan), &shape, m, 4, 1, &make).unwrap();
    for r in &rows { println!("NN {} {:.2?} {:.2?} {:.2} p {:.2e}", r.nominal_n_mm, r.at_rest_n_mm, r.at_speed_n_mm, r.delta_percent, r.test.unwrap().p); }
    for place in ["peak","centre","trough"] { for d in [1.0,-1.0] { for half in [0.5, 0.98] { let k: Vec<f64> = all.iter().filter(|i| i.record.commanded_n_mm == 150.0 && i.record.pulse.place==place && i.record.pulse.direction==d && (place!="centre" || ((i.record.pulse.time_s/10.0).fract()-half).abs()<0.01)).map(|i| i.estimate.stiffness_n_mm).collect(); println!("  {place} {d:+} {half} {:.1?} n {}", mean_and_deviation(&k), k.len()); } } }
    let mut obs = vec![];
    for p in pam_data::collect_paths(&["/tmp/rig-logs".into()]).unwrap() { for r in pam_data::open_recordings(&p, &Default::default()).unwrap() { obs.push(observe(&r).unwrap()); } }
    let ep = EquilibriumPoint::fit(&obs).unwrap();
    let (rows, _) = comparison::rows(&ep.commands(&t), &shape, m, 4, 1, &make).unwrap();
    for r in &rows { println!("EP {} {:.2?} {:.2?} {:.2} p {:.2e}", r.nominal_n_mm, r.at_rest_n_mm, r.at_speed_n_mm, r.delta_percent, r.test.unwrap().p); }
}
