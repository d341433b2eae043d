use pam_control::motion::Motion;
use pam_control::motion::table::MotionTable;

#[test]
fn a_spline_follows_a_sine() {
    let t: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.05).collect();
    let text = t.iter().fold("time_s,displacement_mm,force_n\n".to_owned(), |s, t| {
        s + &format!("{t},{},{}\n", t.sin(), 2.0 * t)
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motion.csv");
    std::fs::write(&path, text).unwrap();
    let motion = MotionTable::read(&path).unwrap();
    for k in 20..180 {
        let time = f64::from(k) * 0.05 + 0.013;
        let p = motion.at(time);
        assert!((p.displacement_mm - time.sin()).abs() < 1e-6);
        assert!((p.velocity_mm_s - time.cos()).abs() < 1e-4);
        assert!((p.acceleration_mm_s2 + time.sin()).abs() < 1e-3);
        assert!((motion.force_n(time).unwrap() - 2.0 * time).abs() < 1e-12);
    }
    assert!(motion.stiffness_n_mm(1.0).is_none());
}
