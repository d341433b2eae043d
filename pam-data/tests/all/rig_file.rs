//! Rig files: units, layouts of text, and what makes no sense.

use pam_data::rig_file::units::{ALL, Quantity};
use pam_data::{LoadOptions, RigFile, open_recordings};
use std::path::Path;

const RIG: &str = "[columns]\ntime = { column = 1, unit = \"samples\" }\n\
    displacement = { column = \"q\", unit = \"deg\", sign = -1, offset = 10 }\n\
    pressure_flexor = { column = \"a\", unit = \"bar\", reference = \"gauge\" }\n\
    pressure_extensor = { column = \"b\", unit = \"psi\", reference = \"absolute\" }\n\
    force = { column = \"i\", unit = \"A\", scale = 0.5 }\n\
    [file]\nrate_hz = 200\n\
    [drive]\npulley_radius_mm = 20\ntorque_constant_nm_per_a = 0.03\ngear_ratio = 10\n\
    [filter]\nvelocity_hz = 0\n[air]\natmosphere_kpa = 95\n";

fn rig(text: &str) -> Result<RigFile, String> {
    RigFile::parse(text, Path::new("rig.toml")).map_err(|e| e.to_string())
}

/// Every quantity is converted as the definitions of the units say.
#[test]
fn columns_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.txt");
    // Tabs, decimal commas, a comment and a column of text.
    let mut text = "# a log\nn\tq\ta\tb\ti\tnote\n".to_owned();
    for k in 0..9 {
        text += &format!("{k}\t{},5\t2,0\t50\t-1,2\tok\n", k);
    }
    std::fs::write(&path, text).unwrap();
    let options = LoadOptions { rig: Some(rig(RIG).unwrap()), ..LoadOptions::default() };
    let r = open_recordings(&path, &options).unwrap().remove(0);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
    close(r.time_s[4], 0.02);
    close(r.displacement_mm[3], -(13.5_f64.to_radians()) * 20.0);
    close(r.pressure_flexor_kpa[0], 295.0);
    close(r.pressure_extensor_kpa[0], 50.0 * 6.894_76);
    // 0.6 A · 0.03 N·m/A · 10 over 20 mm.
    close(r.force_mn[0], -0.6 * 0.03 * 10.0 / 0.02 * 1e3);
    // A straight line.
    close(r.velocity_mm_s[2], -1.0_f64.to_radians() * 20.0 * 200.0);
    assert!(r.preprocessing.contains("v = gradient of x"), "{}", r.preprocessing);
}

/// No name belongs to two units of a quantity.
#[test]
fn names_of_units_are_unique() {
    for (k, unit) in ALL.iter().enumerate() {
        let names = |u: &'static pam_data::rig_file::units::Unit| {
            [u.name].into_iter().chain(u.aliases.iter().copied())
        };
        for other in ALL[..k].iter().filter(|o| o.quantity == unit.quantity) {
            assert!(names(unit).all(|n| names(other).all(|o| o != n)), "{unit:?} {other:?}");
        }
    }
    let _ = Quantity::Time;
}

/// A rig file survives writing and reading; what makes no sense is named by its key.
#[test]
fn rig_files_are_checked() {
    let read = rig(RIG).unwrap();
    assert_eq!(rig(&read.to_toml()).unwrap(), read);
    for (from, to, named) in [
        ("gear_ratio = 10\n", "", "drive.gear_ratio"),
        ("rate_hz = 200", "rate_hz = -1", "file.rate_hz must be positive"),
        ("sign = -1", "sign = 2", "columns.displacement.sign"),
        ("reference = \"gauge\"", "scale = 2", "reference"),
        ("column = 1,", "column = 0,", "counted from one"),
        ("\"bar\"", "\"mm\"", "no unit of pressure"),
        ("[air]", "[joint]\nmass_kg = 1\ninertia_kg_m2 = 1\n[air]", "say the same"),
        ("[air]", "[muscles]\nbraid_angle_deg = 60\n[air]", "54.7"),
    ] {
        let error = rig(&RIG.replace(from, to)).unwrap_err();
        assert!(error.contains(named), "{named}: {error}");
    }
}

/// The force of ideal muscles is the derivative of Chou and Hannaford's equation, taken by differences here.
#[test]
fn the_spring_of_the_data_sheet_is_that_of_braided_muscles() {
    let text =
        "[muscles]\nradius_mm = 8\nlength_mm = 150\nbraid_angle_deg = 25\n[joint]\nmass_kg = 2\n";
    let spring = rig(text).unwrap().spring_damper();
    let model = rig(text).unwrap().model(spring);
    let (pressure, h) = (350.0, 1e-4);
    let masses = model.gas_law_masses(0.0, [pressure; 2]);
    let pull = |x: f64, p: f64| {
        let (sin, tan) = (25_f64.to_radians().sin(), 25_f64.to_radians().tan());
        let shorter = 1.0 - x / 150.0;
        let area = std::f64::consts::PI * 64.0;
        (p - 101.325) * area * (3.0 / (tan * tan) * shorter * shorter - 1.0 / (sin * sin))
    };
    let force = |x: f64| {
        let [flexor, extensor] = model.gas_law_pressures_kpa(x, masses);
        pull(-x, extensor) - pull(x, flexor)
    };
    let stiffness = (force(h) - force(-h)) / (2.0 * h);
    let sum = masses.flexor_g + masses.extensor_g;
    let line = spring.stiffness_mn_mm + spring.stiffness_per_mass_mn_mm_g * sum;
    assert!((line / stiffness - 1.0).abs() < 1e-6, "{line} {stiffness}");
}

/// What a rig file says of a recording besides its columns is kept in both formats: air, reading at rest, filters, sizes.
#[test]
fn recordings_keep_their_rig_when_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.txt");
    let mut text = "n\tq\ta\tb\ti\n".to_owned();
    for k in 0..60 {
        text += &format!("{k}\t{}\t2.0\t50\t1.2\n", (f64::from(k) / 9.0).sin());
    }
    std::fs::write(&path, text).unwrap();
    let more = "rest_s = 0.1\nmass_flexor_g = 0.07\nmass_extensor_g = 0.08\n";
    let described = RIG
        .replace("velocity_hz = 0", "displacement_hz = 20\nforce_hz = 10")
        .replace("atmosphere_kpa = 95\n", &format!("atmosphere_kpa = 95\n{more}"));
    let options = LoadOptions { rig: Some(rig(&described).unwrap()), ..LoadOptions::default() };
    let original = open_recordings(&path, &options).unwrap().remove(0);
    assert!(original.sealed.is_some() && original.given_masses.is_some());
    let sizes = original.rig.clone().unwrap();
    assert_eq!(sizes.model(()), options.rig.as_ref().unwrap().model(()));
    assert!(sizes.columns.is_none());
    for name in ["again.csv", "again.npz"] {
        let file = folder.path().join(name);
        pam_data::write_recording(&file, &original).unwrap();
        let back = open_recordings(&file, &LoadOptions::default()).unwrap().remove(0);
        assert_eq!(back.sealed, original.sealed, "{name}");
        assert_eq!(back.given_masses, original.given_masses, "{name}");
        assert_eq!(back.rig, original.rig, "{name}");
        assert_eq!(back.low_passed.cutoff_hz, original.low_passed.cutoff_hz, "{name}");
        assert_eq!(back.displacement_mm, original.displacement_mm, "{name}");
        assert_eq!(pam_data::rig_of(&[&file]).unwrap().as_ref(), Some(&*sizes), "{name}");
    }
    // A rig that cannot be is named with its line.
    let text = std::fs::read_to_string(folder.path().join("again.csv")).unwrap();
    let broken = folder.path().join("broken.csv");
    std::fs::write(&broken, text.replace("gear_ratio = 10.0", "gear_ratio = -1")).unwrap();
    let said = open_recordings(&broken, &LoadOptions::default()).unwrap_err().to_string();
    assert!(said.contains("broken.csv:6") && said.contains("drive.gear_ratio"), "{said}");
}

/// Columns are looked through once, not once for each of them: 30,000 columns take a moment instead of minutes.
#[test]
fn a_guess_of_a_wide_table_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.csv");
    let row =
        |cell: &dyn Fn(usize) -> String| (0..30_000).map(cell).collect::<Vec<_>>().join(",") + "\n";
    let text = row(&|k| format!("a{k}")) + &row(&|k| k.to_string()).repeat(3);
    std::fs::write(&path, text).unwrap();
    let begun = std::time::Instant::now();
    let message = RigFile::guess(&path).unwrap_err().to_string();
    assert!(message.contains("wide.csv") && message.contains("no column could be taken"));
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
}
