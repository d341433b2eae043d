use pam_data::Recording;
use pam_data::recording::split_at_gaps;
use std::path::Path;

#[test]
fn gaps_split_and_keep_the_sealed_reading() {
    let mut r = Recording::empty(Path::new("run.csv"));
    r.time_s = vec![0.0, 0.1, 0.2, 0.7, 0.8, 0.9, 1.5];
    for column in [
        &mut r.displacement_mm,
        &mut r.velocity_mm_s,
        &mut r.pressure_flexor_kpa,
        &mut r.pressure_extensor_kpa,
        &mut r.force_mn,
    ] {
        *column = (0..7).map(|k| f64::from(k) + 1.0).collect();
    }
    let parts = split_at_gaps(r.clone(), 2).unwrap();
    assert_eq!(parts.len(), 2);
    assert_eq!(parts[1].time_s, [0.7, 0.8, 0.9]);
    assert_eq!(parts[1].name, "run#2");
    assert_eq!(parts[1].sealed.unwrap().pressure_flexor_kpa, 1.0);
    let notes = parts[0].notes.join(" ");
    assert!(notes.contains("2 gap(s)") && notes.contains("1 part(s)"), "{notes}");
    assert!(split_at_gaps(r, 4).unwrap_err().to_string().contains("3 parts"));
}

#[test]
fn names_give_the_commanded_pressures() {
    let command = |name: &str| Recording::empty(Path::new(name)).command_psi;
    assert_eq!(command("nn_3060"), Some([30.0, 60.0]));
    assert_eq!(command("nn_3060_excerpt"), Some([30.0, 60.0]));
    assert_eq!(command("nn_30"), None);
    assert_eq!(command("data"), None);
    assert_eq!(command("nn_a\u{e9}b\u{e9}"), None);
}
