//! The raw-log loader against NumPy and SciPy (`fixtures/published_loader.py`), gaps, and masses.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use pam_data::preprocess::recordings_from_raw_log;
use pam_data::{
    LoadOptions, MassChoice, MassOrigin, MuscleSurfaces, RawLog, RawLogOptions, Recording,
    open_recordings, resolve_masses,
};
use pam_tests::{published, published_weights};
use std::f64::consts::TAU;
use std::path::Path;

const HEADER: &str = "#Date: 26-Sep-2025 00:21:11\n#\n#Parameters:\n#\tFs = 1000 (Hz)\n#\n\
    # frame\tx\tu\tcurrent\tp_res\tpd1\tpm1\tu1\tpd2\tpm2\tu2\tsync\t\n";

/// The log of `fixtures/published_loader.py`, without the frames that `keep` refuses.
fn log_text(keep: impl Fn(usize) -> bool) -> String {
    let mut text = HEADER.to_owned();
    for k in (0..6000).filter(|&k| keep(k)) {
        let t = (k as f64 - 2100.0) / 1000.0;
        let drive = if k < 2100 { 0.0 } else { (TAU * 0.5 * t).sin() };
        let wave = (0.37 * k as f64).sin() * (0.011 * k as f64).cos();
        let u = if k < 2100 { 0.0 } else { 2047.0 + 800.0 * drive };
        text += &format!(
            "{}\t{:.6}\t{u:.6}\t{:.6}\t96.7\t30.0\t{:.6}\t-1\t60.0\t{:.6}\t-1\t{}\t\n",
            6240 + k,
            0.878906 - 9.0 * drive + 0.04 * wave,
            -drive + 0.03 * wave,
            30.1 - 1.5 * drive + 0.02 * wave,
            59.7 + 2.5 * drive - 0.03 * wave,
            u8::from(k >= 2100)
        );
    }
    text
}

fn recordings(text: &str) -> Vec<Recording> {
    let log = RawLog::parse(Path::new("nn_3060"), text.as_bytes()).unwrap();
    recordings_from_raw_log(&log, &RawLogOptions::default()).unwrap()
}

#[test]
fn the_default_is_the_published_preprocessing() {
    let all = recordings(&log_text(|_| true));
    let [r] = &all[..] else { panic!("one recording") };
    assert_eq!(r.len(), 3901);
    assert_eq!(r.command_psi, Some([30.0, 60.0]));
    let sealed = r.sealed.unwrap();
    assert_relative_eq!(sealed.pressure_flexor_kpa, 308.857_153_342_219_6, max_relative = 1e-12);
    assert_relative_eq!(sealed.pressure_extensor_kpa, 512.942_355_745_353_9, max_relative = 1e-12);
    // Index; time, x, v, P_f, P_e, F from SciPy.
    let expected: [(usize, [f64; 6]); 5] = [
        (
            0,
            [
                0.0,
                -0.10024527762988276,
                2.312876892773805,
                308.8285295381287,
                512.9953802174335,
                -142.25156253191292,
            ],
        ),
        (
            1,
            [
                0.001,
                -0.09793240073710896,
                2.3799920436639033,
                308.8052240638384,
                513.0339341016963,
                186.62866156836105,
            ],
        ),
        (
            500,
            [
                0.5,
                0.9739137912786378,
                0.1711346320642515,
                298.51787895401094,
                530.1738748422786,
                133552.38924948382,
            ],
        ),
        (
            1234,
            [
                1.234,
                -0.8270234067606069,
                -2.5060135432207753,
                315.7721567064946,
                501.4185372205641,
                -89390.87217362908,
            ],
        ),
        (
            3900,
            [
                3.9,
                -0.4510459097056439,
                2.129988202227373,
                312.10455246754657,
                507.5144660709108,
                -40417.45439456408,
            ],
        ),
    ];
    for (i, row) in expected {
        let ours = [
            r.time_s[i],
            r.displacement_mm[i],
            r.velocity_mm_s[i],
            r.pressure_flexor_kpa[i],
            r.pressure_extensor_kpa[i],
            r.force_mn[i],
        ];
        for (a, b) in ours.into_iter().zip(row) {
            assert_abs_diff_eq!(a, b, epsilon = 1e-9 * b.abs().max(1.0));
        }
    }
}

/// Masses of SciPy's SLSQP on the same surfaces.
#[test]
fn surface_masses_match_an_independent_optimiser() {
    let surfaces = MuscleSurfaces::read(published("poly44_all_fits.mat")).unwrap();
    let all = recordings(&log_text(|_| true));
    let m = surfaces.masses(&all[0]).unwrap();
    assert_abs_diff_eq!(m.flexor_g, 0.07495866271198212, epsilon = 2e-8);
    assert_abs_diff_eq!(m.extensor_g, 0.078783475993394, epsilon = 2e-8);
    // Pressures of the fits are absolute: no air, no pressure.
    assert!(surfaces.pressure_and_force(true, 0.0, 0.0).0.abs() < 1.0);
}

#[test]
fn masses_follow_the_choice_and_given_ones_win() {
    let saved = pam_data::load_model(published_weights()).unwrap();
    let surfaces = MuscleSurfaces::read(published("poly44_all_fits.mat")).unwrap();
    let mut r = recordings(&log_text(|_| true)).remove(0);
    let resolve = |r: &Recording, trained, choice| {
        resolve_masses(r, &saved.model, trained, choice, Some(&surfaces)).unwrap()
    };
    let (gas, origin) = resolve(&r, true, MassChoice::Auto);
    assert_eq!(origin, MassOrigin::GasLaw);
    // m = P V / C at x near zero: V = π 25 · 200 mm³ to first order.
    assert_relative_eq!(gas.flexor_g, 308.857 * 15707.96 / 8.47e7, max_relative = 4e-3);
    assert_eq!(resolve(&r, false, MassChoice::Auto).1, MassOrigin::Surfaces);
    assert_eq!(resolve(&r, false, MassChoice::GasLaw).1, MassOrigin::GasLaw);
    assert!(resolve_masses(&r, &saved.model, true, MassChoice::Surfaces, None).is_err());
    r.given_masses = Some(pam_core::SealedMasses { flexor_g: 0.01, extensor_g: 0.02 });
    let (given, origin) = resolve(&r, false, MassChoice::Surfaces);
    assert_eq!((given.flexor_g, origin), (0.01, MassOrigin::Given));
}

/// A gap in the frame counter splits the run; times keep counting, nothing is stretched, and both
/// parts equal what they would be if filtered alone.
#[test]
fn frame_gaps_split_the_recording() {
    let parts = recordings(&log_text(|k| !(3500..3700).contains(&k)));
    assert_eq!(parts.len(), 2);
    assert_eq!(parts[0].len() + parts[1].len(), 3701);
    assert_abs_diff_eq!(parts[1].time_s[0], 1.601, epsilon = 1e-12);
    assert_eq!(parts[0].name, "nn_3060#1");
    assert!(parts[0].notes.iter().any(|n| n.contains("gap")), "{:?}", parts[0].notes);
    // Half a sample's gap is none; both parts keep the sealed reading.
    assert_eq!(parts[0].sealed, parts[1].sealed);
    let whole = recordings(&log_text(|_| true)).remove(0);
    let (a, b) = (parts[1].displacement_mm[700], whole.displacement_mm[1601 + 700]);
    assert_abs_diff_eq!(a, b, epsilon = 1e-9);
}

/// The real excerpt: its format is read, its gap is seen, and its shortness is told.
#[test]
fn the_real_excerpt_is_understood() {
    let path = published("nn_3060_excerpt.txt");
    let log = RawLog::read(&path).unwrap();
    assert_eq!((log.len(), log.frame_rate_hz), (13, Some(1000.0)));
    assert_eq!(log.current_a()[0], 0.022461);
    assert_eq!(log.pressure_extensor_psi()[12], -0.040985);
    let error = open_recordings(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("13 rows") && error.contains("2000"), "{error}");
}
