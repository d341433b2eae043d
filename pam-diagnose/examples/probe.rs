use pam_data::*;
use pam_diagnose::{effects::*, simulation::*};
use pam_train::*;
use std::path::Path;
use std::time::Instant;
fn main() {
    let saved = load_model(Path::new("../shared/pneu-sim/hybrid_model_puresine_16.eqx")).unwrap();
    let rec = open_recordings(Path::new("/tmp/ideal/nn_3060"), &LoadOptions::default())
        .unwrap()
        .remove(0);
    let (masses, origin) =
        resolve_masses(&rec, &saved.model, true, MassChoice::Auto, None).unwrap();
    let s = Subject { recording: rec, masses, origin };
    let t = Instant::now();
    let mut settings = SolverSettings::default();
    settings.interpolation = pam_solvers::Interpolation::Hold;
    let p = predict(&saved.model, &s.recording, masses, &settings).unwrap();
    println!("predict {:?}", t.elapsed());
    let t = Instant::now();
    let trial = Trial::new(&saved.model, &s);
    println!("trial {:?} points {}", t.elapsed(), trial.points());
    let base = Base::of(&saved.model);
    let mut out = Trajectory::default();
    for _ in 0..2 {
        let t = Instant::now();
        simulate::<f64>(&trial, &base, &[], &[], &Nuisances::none(), &mut out).unwrap();
        println!("f64 {:?}", t.elapsed());
    }
    for (c, pc) in [&p.channels.x, &p.channels.v, &p.channels.pf, &p.channels.pe].iter().enumerate()
    {
        let e = out.channels[c]
            .iter()
            .enumerate()
            .map(|(k, v)| {
                (v - pc[(((trial.step_s * 1000.0).round() as usize) * k).min(pc.len() - 1)]).abs()
            })
            .fold(0.0, f64::max);
        println!("channel {c}: max dev {e:.6}");
    }
    let t = Instant::now();
    simulate::<f64>(
        &trial,
        &base,
        &[&CoulombFriction, &Hysteresis],
        &[20.0, 10.0, 0.5],
        &Nuisances::none(),
        &mut out,
    )
    .unwrap();
    println!("f64 2 effects {:?}", t.elapsed());
    let mut out = Trajectory::default();
    let t = Instant::now();
    let mut n = Nuisances::<Derivatives>::none();
    n.log_mass = Derivatives::variable(0.0, 0);
    simulate::<Derivatives>(&trial, &base, &[], &[], &n, &mut out).unwrap();
    println!("dual {:?} {}", t.elapsed(), out.channels[0][5000].derivatives[0]);
    let mut o2 = Trajectory::default();
    let mut o3 = Trajectory::default();
    let mut m = Nuisances::<f64>::none();
    m.log_mass = 1e-4;
    simulate::<f64>(&trial, &base, &[], &[], &m, &mut o2).unwrap();
    m.log_mass = -1e-4;
    simulate::<f64>(&trial, &base, &[], &[], &m, &mut o3).unwrap();
    println!("fd {}", (o2.channels[0][5000] - o3.channels[0][5000]) / 2e-4);
    let t = Instant::now();
    let pv = [
        Derivatives::variable(20.0, 0),
        Derivatives::variable(10.0, 1),
        Derivatives::variable(0.5, 2),
    ];
    simulate::<Derivatives>(&trial, &base, &[&CoulombFriction, &Hysteresis], &pv, &n, &mut out)
        .unwrap();
    println!("dual 2 effects {:?}", t.elapsed());
}
