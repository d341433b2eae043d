use pam_cli::rig_joint::RigJoint;
use pam_control::execution::*; use pam_control::experiments::*; use pam_control::synthesis::*;
use pam_rig::RigParameters; use std::time::Instant;
fn main() {
    let model = pam_data::load_model(std::path::Path::new("pam-cli/models/default.safetensors")).unwrap().model;
    let s = SynthesisSettings::published(MassBounds::trained(&model));
    let t0 = Instant::now();
    let t = stiffness::staircase_targets(&stiffness::STAIRCASE_N_MM).unwrap();
    let plan = Plan::new(&model, t, s).unwrap();
    println!("plan {:?} {:?}", t0.elapsed(), plan.summary().nearest_stiffness);
    let c = Commands::from(&plan);
    let mut j = RigJoint::new(&RigParameters::default(), 1, c.pressures_kpa(0.0)).unwrap();
    let shape = PulseShape::default();
    let t0 = Instant::now();
    let r = perturb(&mut j, &c, 4.0, &pam_control::identification::staircase_pulses(6, 16.0, 2), &shape);
    println!("perturb {:?}", t0.elapsed());
    let t0 = Instant::now();
    for r in &r { pam_control::identification::identify(&pam_control::identification::Response::of_pulse(r, 300.0)).unwrap(); }
    println!("identify {:?} for {}", t0.elapsed(), r.len());
}
