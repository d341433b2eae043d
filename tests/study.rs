use pam_data::*; use pam_train::*; use pam_diagnose::{effects, simulation::*, fit::*, search::*};
use pam_tests::plant::{self, *};
use std::time::Instant; use std::path::Path;
use rayon::prelude::*;
fn parse(s: &str) -> Vec<Hidden> {
    s.split('+').filter(|s| !s.is_empty() && *s != "none").map(|e| { let (id, p) = e.split_once(':').unwrap_or((e, "")); 
      hidden(id, &p.split(',').filter(|s| !s.is_empty()).map(|kv| { let (k, v) = kv.split_once('=').unwrap(); (k, v.parse::<f64>().unwrap()) }).collect::<Vec<_>>()) }).collect()
}
fn rms(e: &ChannelErrors) -> [f64; 3] { e.mean().map(|m| (m.sqrt() * 1e4).round() / 1e4) }
fn rig(effects: &str, conditions: &[[f64; 2]], ideal: bool, seed: u64, share: f64) -> Vec<Recording> {
    let dir = tempfile::tempdir().unwrap();
    let mut parameters = pam_rig::RigParameters::default();
    if ideal { parameters.sensors = pam_rig::sensors::SensorParameters::ideal(); }
    parameters.effects = effects.split('+').filter(|s| !s.is_empty() && *s != "none").map(|e| e.parse().unwrap()).collect();
    let mut protocol = pam_rig::Protocol::paper();
    for c in &mut protocol.current { if let pam_rig::protocol::CurrentSegment::Sine { duration_s, .. } = c { *duration_s *= share } }
    protocol.conditions = Some(pam_rig::Conditions::List(conditions.iter().map(|c| c.map(|v| v as u8)).collect()));
    let session = pam_rig::Session { rig: parameters, protocol, seed, truth: false, note: String::new() };
    session.record_into(dir.path(), true, &|_| {}).unwrap();
    let mut paths = collect_paths(&[dir.path().to_owned()]).unwrap(); paths.sort();
    paths.par_iter().map(|p| open_recordings(p, &LoadOptions::default()).unwrap().remove(0)).collect()
}
fn main() {
    let mut args = std::env::args().skip(1);
    let mode = args.next().unwrap();
    let most: usize = args.next().unwrap().parse().unwrap();
    let share: f64 = args.next().unwrap().parse().unwrap();
    let saved = if mode == "plant" { load_model(&pam_tests::published_weights()).unwrap() } else { load_model(Path::new("pam-cli/models/default.safetensors")).unwrap() };
    let conditions = [[45.0, 45.0], [30.0, 60.0], [70.0, 60.0]];
    let subject = |r: Recording| { let masses = plant::masses(&saved.model, &r); Subject { recording: r, masses, origin: MassOrigin::GasLaw } };
    let base = Base::of(&saved.model);
    // healthy for the rig
    let mut fixed: Vec<(&dyn effects::AnyEffect, Vec<f64>)> = vec![];
    let mut healthy_floor = [0.0; 3];
    if mode.starts_with("rig") {
        let hc = [[45.0, 45.0], [30.0, 60.0], [60.0, 30.0], [70.0, 60.0], [40.0, 70.0]];
        let trials: Vec<Trial> = rig("", &hc, mode == "rigideal", 99, share).into_iter().map(|r| Trial::new(&saved.model, &subject(r))).collect();
        let all: Vec<&Trial> = trials.iter().collect();
        let floors = noise_floors(&all);
        let split = Split { train: Problem::new(trials[..3].iter(), base, 0.5, floors), held: Problem::new(trials[3..].iter(), base, 0.5, floors), same_trials: false };
        let search = Search { evidence: gather(&all[..3], &base), split, candidates: effects::ALL.to_vec() };
        let f = search.run(&[], 3, &Acceptance::default(), &|_| {}).unwrap();
        println!("healthy: base {:?}/{:?} floors {:?}", rms(&f.base.fit.errors), rms(&f.base.held), floors.0);
        println!("   best {:?} {:?} -> {:?} / {:?}", f.best.fit.hypothesis.ids(), f.best.fit.hypothesis.values, rms(&f.best.fit.errors), rms(&f.best.held));
        fixed = f.best.fit.hypothesis.fitted().map(|(e, v)| (e, v.to_vec())).collect();
        healthy_floor = rms(&f.best.fit.errors.and(&f.best.held));
    }
    for spec in args {
        let subjects: Vec<Subject> = if mode == "plant" {
            let h = parse(&spec);
            conditions.par_iter().enumerate().map(|(i, &psi)| subject(plant::record(&saved.model, &format!("nn_{}{}", psi[0], psi[1]), psi, &excitation(share), &h, Noise::default(), 7 + i as u64))).collect()
        } else { rig(&spec, &conditions, mode == "rigideal", 5, share).into_iter().map(subject).collect() };
        let t = Instant::now();
        let trials: Vec<Trial> = subjects.iter().map(|s| Trial::new(&saved.model, s)).collect();
        let all: Vec<&Trial> = trials.iter().collect();
        let mut floors = noise_floors(&all);
        for c in 0..3 { floors.0[c] = floors.0[c].hypot(healthy_floor[c]); }
        let split = Split { train: Problem::new(trials[..2].iter(), base, 0.5, floors), held: Problem::new(trials[2..].iter(), base, 0.5, floors), same_trials: false };
        let search = Search { evidence: gather(&all[..2], &base), split, candidates: effects::ALL.to_vec() };
        let f = search.run(&fixed, most, &Acceptance::default(), &|_| {}).unwrap();
        println!("{spec} {:.1?} base {:?}/{:?} floors {:?}", t.elapsed(), rms(&f.base.fit.errors), rms(&f.base.held), floors.0.map(|f| (f*1e4).round()/1e4));
        println!("   BEST {:?} {:?} -> {:?} / {:?} lim {:?}", f.best.fit.hypothesis.ids(), f.best.fit.hypothesis.values, rms(&f.best.fit.errors), rms(&f.best.held), f.best.fit.at_limit);
        for s in f.singles.iter().take(3) {
            println!("     {:?} {:?} held {:?} total {:.0} (base {:.0}) lim {:?}", s.fit.hypothesis.ids(), s.fit.hypothesis.values, rms(&s.held), s.total, f.base.total, s.fit.at_limit);
        }
    }
}
