//! Time of the inverse synthesis for a sample, on one core.
//!
//! Each motion is solved in stretches of 2048 samples (16 segments of 128); the median over the stretches and
//! repeats is printed, with the largest residual and the share of samples whose stiffness is reached.
//! Unreachable samples, whose whole curve of masses is followed, are shown by themselves.

use pam_bench::published_model;
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::synthesis::plan::targets;
use pam_control::synthesis::{MassBounds, Outcome, SynthesisSettings, Synthesiser};
use std::time::Instant;

const STRETCH: usize = 2048;
const REPEATS: usize = 5;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("one thread starts");
    let model = published_model();
    let settings = SynthesisSettings::published(MassBounds::trained(&model));
    let synthesiser = Synthesiser::new(&model, settings).expect("settings are right");
    println!("motion                        K    µs a sample   residual (mN)   reached");
    for (motion, stiffness) in [
        ("sine:A=1,f=0.1", 150.0),
        ("sine:A=2,f=0.1,duration=10", 160.0),
        ("sine:A=1,f=1,duration=10", 140.0),
        ("triangle:A=1,f=0.1,duration=10", 150.0),
        ("minimum-jerk:from=-1,to=1,T=4", 150.0),
        ("sine:A=1,f=0.1,duration=10", 180.0),
    ] {
        let spec = MotionSpec::parse(motion).expect("a motion");
        let profile = StiffnessProfile::Constant(stiffness);
        let all = targets(&spec, Some(&profile), 0.0, 1000.0).expect("targets");
        let (mut times, mut residual, mut reached) = (Vec::new(), 0.0_f64, 0);
        for repeat in 0..REPEATS {
            for stretch in all.chunks(STRETCH) {
                let begin = Instant::now();
                let solutions = synthesiser.solve(stretch).expect("finite targets");
                times.push(1e6 * begin.elapsed().as_secs_f64() / stretch.len() as f64);
                if repeat == 0 {
                    residual = solutions.iter().fold(residual, |m, s| m.max(s.residual_mn.abs()));
                    reached += solutions.iter().filter(|s| s.outcome == Outcome::Reached).count();
                }
            }
        }
        times.sort_by(f64::total_cmp);
        let median = times[times.len() / 2];
        let share = 100.0 * reached as f64 / all.len() as f64;
        println!("{motion:30} {stiffness:3.0} {median:12.1} {residual:15.1e} {share:8.1} %");
    }
}
