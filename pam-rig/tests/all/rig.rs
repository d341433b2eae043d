use pam_rig::RigParameters;

#[test]
fn parameters_survive_their_file() {
    let mut rig = RigParameters::default();
    rig.effects.push("creep".parse().unwrap());
    rig.plant.heat = pam_rig::plant::HeatExchange::Isothermal;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, rig.to_toml()).unwrap();
    assert_eq!(RigParameters::read(&path).unwrap(), rig);
    std::fs::write(&path, "[plant]\n\nmass = 3\n").unwrap();
    let message = RigParameters::read(&path).unwrap_err().to_string();
    assert!(message.contains("rig.toml:3: unknown field `mass`"), "{message}");
}
