//! Reading files written by NumPy and SciPy (`tests/files/make.py`).

use pam_data::formats::npy::{Array, NpyError, read_npy, read_npy_texts, write_npy, write_npy_f32};
use pam_data::formats::{mat, npz};
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/files").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap()
}

fn array(name: &str) -> Result<Array, NpyError> {
    read_npy(&mut bytes(name).as_slice())
}

/// `arange(6).reshape(2, 3) / 7`.
fn table() -> Array {
    Array { shape: vec![2, 3], values: (0..6).map(|k| f64::from(k) / 7.0).collect() }
}

#[test]
fn every_layout_of_numpy_is_read() {
    for name in ["c_order.npy", "fortran.npy", "big_endian.npy", "version_2.npy"] {
        assert_eq!(array(name).unwrap(), table(), "{name}");
    }
    assert_eq!(array("integers.npy").unwrap().values, [-3.0, 0.0, 70000.0]);
    assert_eq!(array("bytes.npy").unwrap().values, [1.0, 0.0]);
    assert_eq!(array("scalar.npy").unwrap(), Array::scalar(-0.1));
    assert!(
        matches!(array("complex.npy"), Err(NpyError::Unsupported(what)) if what.contains("c16"))
    );
    let texts = read_npy_texts(&mut bytes("texts.npy").as_slice()).unwrap();
    assert_eq!(texts, ["ν", "long name", ""]);
    assert!(read_npy_texts(&mut bytes("c_order.npy").as_slice()).is_err());
    let packed = npz::read(&path("packed.npz")).unwrap();
    assert_eq!(packed["x"], table());
    let names = npz::read_texts(&path("packed.npz"), "names").unwrap();
    assert_eq!(names.unwrap(), ["a", "b"]);
}

#[test]
fn records_are_written_as_numpy_writes_them() {
    let mut written = Vec::new();
    write_npy(&mut written, &table()).unwrap();
    assert_eq!(written, bytes("c_order.npy"));
    written.clear();
    write_npy(&mut written, &Array::scalar(-0.1)).unwrap();
    assert_eq!(written, bytes("scalar.npy"));
    for shape in [vec![3], vec![3, 1], vec![1, 1, 3], vec![0]] {
        let values = vec![0.25; shape.iter().product::<u64>() as usize];
        let mut written = Vec::new();
        write_npy_f32(&mut written, &shape, &values).unwrap();
        let mut rest = written.as_slice();
        assert_eq!(read_npy(&mut rest).unwrap(), Array { shape, values });
        assert!(rest.is_empty(), "a record is read to its end and no further");
    }
}

#[test]
fn damaged_records_are_refused() {
    let whole = bytes("c_order.npy");
    for cut in 0..whole.len() {
        assert!(read_npy(&mut &whole[..cut]).is_err(), "cut at {cut}");
    }
    let with = |from: &str, to: &str| {
        let text: String = whole.iter().map(|&b| char::from(b)).collect();
        let bytes: Vec<u8> = text.replacen(from, to, 1).chars().map(|c| c as u8).collect();
        read_npy(&mut bytes.as_slice())
    };
    assert!(with("(2, 3)", "(2, 3)").is_ok());
    for (from, to) in [
        ("NUMPY", "NUMPX"),
        ("(2, 3)", "(2; 3)"),
        ("(2, 3)", "(9, 9)"),
        ("'<f8'", "'<f9'"),
        ("'<f8'", "'<O0'"),
        ("'descr'", "'deskr'"),
        ("\u{1}\0", "\u{9}\0"),
    ] {
        assert!(with(from, to).is_err(), "{from} {to}");
    }
    // More items than a machine holds.
    assert!(with("(2, 3), }             ", "(4000000000, 8000000000), }").is_err());
}

#[test]
fn arrays_of_matlab_files_are_read() {
    for name in ["plain.mat", "packed.mat"] {
        let arrays = mat::read(&path(name)).unwrap();
        let names: Vec<&str> = arrays.keys().map(String::as_str).collect();
        assert_eq!(names, ["f", "k", "u", "x", "z"], "{name}: numbers only");
        let columns: Vec<f64> = [0.0, 3.0, 1.0, 4.0, 2.0, 5.0].map(|v| v / 7.0).to_vec();
        assert_eq!(arrays["x"], columns, "{name}");
        assert_eq!(arrays["k"], [-3.0, 0.0, 70000.0], "{name}");
        assert_eq!((&arrays["u"][..], &arrays["f"][..]), (&[200.0][..], &[0.5, -2.0][..]));
        assert_eq!(arrays["z"], [1.0], "{name}: the real part");
    }
}

#[test]
fn damaged_matlab_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cut.mat");
    for name in ["plain.mat", "packed.mat"] {
        let whole = bytes(name);
        for cut in (0..whole.len()).step_by(3) {
            std::fs::write(&file, &whole[..cut]).unwrap();
            // A file may end after any of its arrays.
            if let Ok(arrays) = mat::read(&file) {
                assert!(arrays.len() < 5 || cut > whole.len() - 300, "{name} cut at {cut}");
            }
        }
        // A corrupt file yields arrays or an error, never a panic.
        for at in 128..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0xff;
            std::fs::write(&file, &damaged).unwrap();
            let _ = mat::read(&file);
        }
    }
}
