use pam_control::experiments::*; use pam_control::synthesis::*; use std::time::Instant;
fn main() {
    let model = pam_data::load_model(std::path::Path::new("pam-cli/models/default.safetensors")).unwrap().model;
    println!("{:?}", model.force.describe());
    let s = SynthesisSettings::published(MassBounds::trained(&model));
    let t0 = Instant::now();
    let plan = Plan::new(&model, comparison::targets().unwrap(), s).unwrap();
    println!("plan {:?} {:?}", t0.elapsed(), plan.summary());
    let w = plan.solutions.iter().filter(|s| s.outcome==Outcome::NearestStiffness).step_by(500).map(|s| (s.masses, s.stiffness_n_mm, s.reachable_n_mm)).take(6).collect::<Vec<_>>(); println!("{w:?}");
}
