use pam_ablate::table::{Column, Table};

fn table() -> Table {
    Table {
        columns: vec![
            ("model.activation".into(), Column::Text(vec![Some("si, lu".into()), None])),
            ("seed".into(), Column::Integer(vec![1, -2])),
            ("loss".into(), Column::Number(vec![None, Some(0.1 + 0.2)])),
        ],
    }
}

#[test]
fn csv_quotes_and_leaves_gaps() {
    let csv = "model.activation,seed,loss\n\"si, lu\",1,\n,-2,0.30000000000000004\n";
    assert_eq!(table().to_csv(), csv);
}

/// A Parquet reader gets the written values back, including missing ones.
#[cfg(feature = "parquet")]
#[test]
fn parquet_holds_the_same() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    let bytes = table().to_parquet("t").unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    let reader = SerializedFileReader::new(file.reopen().unwrap()).unwrap();
    let rows: Vec<Vec<(String, Field)>> = reader
        .get_row_iter(None)
        .unwrap()
        .map(|r| r.unwrap().get_column_iter().map(|(n, f)| (n.clone(), f.clone())).collect())
        .collect();
    let named = |n: &str, f: Field| (n.to_owned(), f);
    let expected = [
        [
            named("model.activation", Field::Str("si, lu".into())),
            named("seed", Field::Long(1)),
            named("loss", Field::Null),
        ],
        [
            named("model.activation", Field::Null),
            named("seed", Field::Long(-2)),
            named("loss", Field::Double(0.300_000_000_000_000_04)),
        ],
    ];
    assert_eq!(rows, expected);
}
