use pam_cli::rig_joint::RigJoint;
use pam_control::execution::*; use pam_control::experiments::*; use pam_control::synthesis::*; use pam_control::equilibrium_point::*;
use pam_rig::RigParameters;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let model = pam_data::load_model(std::path::Path::new(&path)).unwrap().model;
    let b = MassBounds::trained(&model);
    let s = SynthesisSettings::published(b);
    let params = RigParameters::default();
    let make = move |seed: u64, p: [f64;2]| -> Box<dyn Joint> { Box::new(RigJoint::new(&params, seed, p).unwrap()) };
    let m = model.physical().mass_kg;
    let syn = Synthesiser::new(&model, s).unwrap();
    for (x,v) in [(0.0,0.0),(0.0,0.63),(1.0,0.0),(-1.0,0.0),(0.0,6.28)] { let t = Target{time_s:0.0,displacement_mm:x,velocity_mm_s:v,acceleration_mm_s2:0.0,stiffness_n_mm:150.0,load_mn:0.0}; println!("reach {x} {v} {:?}", syn.reachable_n_mm(&t)); }
    if std::env::args().nth(2).is_none() {
    for r in tracking::track(&model, s, &tracking::published_cases(), 1, &make, &||{}).unwrap() {
        println!("{:9} {:9} A {} f {} K {} rmse {:.3} pub {:.3}  p {:.1} kPa, missed {}/{}", r.case.shape, r.case.series, r.case.amplitude_mm, r.case.frequency_hz, r.case.stiffness_n_mm, r.rmse_mm, r.case.published_mm, r.pressure_rmse_kpa, r.plan.nearest_stiffness, r.plan.samples);
    } }
    let w: f64 = std::env::args().nth(3).map_or(0.3, |v| v.parse().unwrap()); let f: f64 = std::env::args().nth(4).map_or(90.0, |v| v.parse().unwrap()); let shape = PulseShape{window_s: w, force_n: f, ..PulseShape::default()};
    let t = stiffness::staircase_targets(&stiffness::STAIRCASE_N_MM).unwrap();
    let plan = Plan::new(&model, t, s).unwrap();
    for i in stiffness::staircase(&Commands::from(&plan), 6, &shape, m, 1, &make).unwrap() {
        println!("stair {} {:+} K {:.1} {:.1?} B {:.0} rmse {:.4} peak {:.3} p {:.0?}", i.record.commanded_n_mm, i.record.pulse.direction, i.estimate.stiffness_n_mm, i.estimate.stiffness_interval_n_mm, i.estimate.damping_kg_s, i.estimate.rmse_mm, i.estimate.peak_mm, i.record.pressures_kpa);
    }
    let t = comparison::targets().unwrap();
    let plan = Plan::new(&model, t.clone(), s).unwrap();
    println!("{:?}", plan.summary());
    let (rows, _) = comparison::rows(&Commands::from(&plan), &shape, m, 6, 1, &make).unwrap();
    for r in &rows { println!("NN {} {:.2?} {:.2?} {:.2} {:?}", r.nominal_n_mm, r.at_rest_n_mm, r.at_speed_n_mm, r.delta_percent, r.test); }
    let mut obs = vec![];
    for p in pam_data::collect_paths(&["/tmp/rig-logs".into()]).unwrap() { for r in pam_data::open_recordings(&p, &Default::default()).unwrap() { obs.push(observe(&r).unwrap()); } }
    let ep = EquilibriumPoint::fit(&obs).unwrap();
    println!("{} {ep:?}", obs.len());
    let (rows, _) = comparison::rows(&ep.commands(&t), &shape, m, 6, 1, &make).unwrap();
    for r in &rows { println!("EP {} {:.2?} {:.2?} {:.2} {:?}", r.nominal_n_mm, r.at_rest_n_mm, r.at_speed_n_mm, r.delta_percent, r.test); }
}
