use pam_data::RawLogOptions;

#[test]
fn options_are_set_by_name_and_checked() {
    let mut o = RawLogOptions::default();
    o.set("cutoff_hz=10").unwrap();
    o.set("search_from_row = 0").unwrap();
    assert_eq!((o.cutoff_hz, o.search_from_row), (10.0, 0));
    assert!(o.set("cutof_hz=10").unwrap_err().contains("cutoff_hz"));
    assert!(o.set("cutoff_hz=ten").unwrap_err().contains("ten"));
    assert!(o.set("sealed_rows=-1").unwrap_err().contains("sealed_rows"));
}
