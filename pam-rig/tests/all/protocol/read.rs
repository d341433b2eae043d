use pam_rig::Protocol;
use std::path::Path;

fn message(text: &str) -> String {
    Protocol::parse(text, Path::new("p.toml")).unwrap_err().to_string()
}

const SINE: &str = "[[current]]\nkind = \"sine\"\namplitude_a = 1.0\nfrequency_hz = 1.0\n";

#[test]
fn faults_are_told_with_their_line() {
    let head = "name = \"a\"\nconditions = [[30, 60]]\n";
    for (text, expected) in [
        (format!("{head}{SINE}duration_s = -1.0\n"), "p.toml:3: current[0].duration_s"),
        (format!("{head}{SINE}duration_s = nan\n"), "p.toml:3: current[0].duration_s"),
        (format!("{head}{SINE}"), "missing field `duration_s`"),
        (format!("{head}{SINE}duration_s = 1.0\nphase = 2\n"), "unknown field `phase`"),
        (format!("{head}[[current]]\nkind = \"square\"\n"), "unknown variant `square`"),
        (format!("{head}frequency = 1\n"), "p.toml:3: unknown field `frequency`"),
        (head.to_owned(), "p.toml:1: nothing happens"),
        (format!("name = \"a\"\n{SINE}duration_s = 1.0"), "neither conditions nor"),
        (
            format!("name = \"a/b\"\nconditions = \"grid\"\n{SINE}duration_s = 1.0"),
            "p.toml:1: name: `a/b`",
        ),
        (
            format!("name = \"a\"\nconditions = [[30, 99]]\n{SINE}duration_s = 1.0"),
            "p.toml:2: conditions: 99 is not a whole number",
        ),
        (
            format!("name = \"a\"\nconditions = [[30]]\n{SINE}duration_s = 1.0"),
            "[30.0] is not a pair",
        ),
        (
            format!("name = \"a\"\nconditions = [[30, 12.5]]\n{SINE}duration_s = 1.0"),
            "12.5 is not a whole",
        ),
        (
            format!("name = \"a\"\nconditions = \"all\"\n{SINE}duration_s = 1.0"),
            "`all` is neither train",
        ),
        (format!("name = \"a\"\nconditions = 3\n{SINE}duration_s = 1.0"), "expected \"train\""),
        ("name = \"a\nconditions".to_owned(), "p.toml:"),
    ] {
        let message = message(&text);
        assert!(message.contains(expected), "{text}\n-> {message}");
    }
}

#[test]
fn pressures_beyond_room_and_supply_are_refused() {
    let text = "name = \"t\"\n\n[[pressure]]\nkind = \"sine\"\nmean_kpa = [150.0, 400.0]\n\
                amplitude_kpa = [80.0, -80.0]\nfrequency_hz = 0.5\nduration_s = 4.0\n";
    assert!(message(text).contains("p.toml:3: pressure[0].amplitude_kpa: 70.0 kPa"));
}

#[test]
fn a_table_is_read_from_beside_the_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let text = "name = \"mine\"\n[[pressure]]\nkind = \"table\"\nfile = \"commands.csv\"\n";
    std::fs::write(&path, text).unwrap();
    assert!(Protocol::read(&path).unwrap_err().to_string().contains("commands.csv"));
    let table =
        "time_s,pressure_extensor_kpa,pressure_flexor_kpa\n0,400,410\n1,420,390\n2,400,410\n";
    std::fs::write(folder.path().join("commands.csv"), table).unwrap();
    let protocol = Protocol::read(&path).unwrap();
    assert_eq!(protocol.duration_s(), 3.0);
    let psi = protocol.targets_psi(1.5).unwrap();
    assert!((psi[0] - (390.0 - 101.325) / 6.89476).abs() < 1e-9);
    std::fs::write(folder.path().join("commands.csv"), table.replace("\n1,", "\nx,")).unwrap();
    let message = Protocol::read(&path).unwrap_err().to_string();
    assert!(message.contains("commands.csv:3") && message.contains("time_s"), "{message}");
}
