use pam_control::motion::*;
use pam_control::synthesis::{*, plan::targets};
use std::time::Instant;
fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let model = pam_data::load_model(std::path::Path::new("../shared/pneu-sim/hybrid_model_puresine_16.eqx")).unwrap().model;
    let bounds = MassBounds::trained(&model);
    println!("{bounds:?}");
    let mut s = SynthesisSettings::published(bounds);
    for lanes in [1, 4, 8, 16, 32] {
        s.lanes = lanes;
        for spec in ["sine:A=1,f=0.1", "sine:A=1,f=1", "sine:A=2,f=0.25"] {
            let t = targets(&MotionSpec::parse(spec).unwrap(), Some(&StiffnessProfile::Constant(150.0)), 0.0, 1000.0).unwrap();
            let syn = Synthesiser::new(&model, s).unwrap();
            let at = Instant::now();
            let sol = syn.solve(&t).unwrap();
            let e = at.elapsed().as_secs_f64();
            let bad = sol.iter().filter(|s| s.outcome != Outcome::Reached).count();
            let none = sol.iter().filter(|s| s.outcome == Outcome::MotionUnreachable).count();
            let g = sol.iter().filter(|s| s.outcome != Outcome::MotionUnreachable).map(|s| s.residual_mn.abs()).fold(0.0, f64::max);
            println!("lanes {lanes} {spec}: n {} {:.2} us/sample, missed {bad} {none}, g {g:.2e}", t.len(), 1e6*e/t.len() as f64);
        }
    }
    let syn = Synthesiser::new(&model, s).unwrap();
    for (x, v) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 5.0), (2.0, 0.0)] {
        let t = Target { time_s: 0.0, displacement_mm: x, velocity_mm_s: v, acceleration_mm_s2: 0.0, stiffness_n_mm: 150.0, load_mn: 0.0 };
        let at = Instant::now();
        let r = syn.reachable_n_mm(&t);
        let e = at.elapsed().as_secs_f64();
        let c = syn.curve(&t);
        println!("{x} {v} {r:?} {:.1} us, {} branches {:?}", e*1e6, c.len(), c.iter().map(|b| b.len()).collect::<Vec<_>>());
    }
}
