use pam_core::{JointModel, PhysicalParameters};
use pam_report::parameter_table;

#[test]
fn the_table_holds_the_models_and_the_known_values() {
    let mut model = JointModel::datasheet(());
    model.auxiliary_damping_kg_s = 1234.0;
    let raw = PhysicalParameters { mass_kg: 299.5, ..PhysicalParameters::datasheet() };
    model.raw = raw.to_raw();
    let html = parameter_table(&model).into_string();
    for part in ["299.50", "253.88", "304.65", "4.5989", "3.6910", "8.4700e7", "1234"] {
        assert!(html.contains(part), "{part} in {html}");
    }
}
