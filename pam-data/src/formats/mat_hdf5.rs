//! MATLAB 7.3 files, which are HDF5 (feature `hdf5`).

use hdf5_pure::File;
use std::collections::BTreeMap;

/// All numeric arrays at the top of a file, in column-major order as MATLAB stores them. Text, cells, structures and
/// complex numbers are passed over.
pub(super) fn read(bytes: Vec<u8>) -> Result<BTreeMap<String, Vec<f64>>, String> {
    let sentence = |e: hdf5_pure::Error| format!("not a sound MATLAB 7.3 (HDF5) file: {e}");
    let root = File::from_bytes(bytes).map_err(sentence)?.root();
    let mut arrays = BTreeMap::new();
    for name in root.datasets().map_err(sentence)? {
        let dataset = root.dataset(&name).map_err(sentence)?;
        let class = dataset.attrs().map_err(sentence)?;
        let is_text = class.get("MATLAB_class").is_some_and(|c| format!("{c:?}").contains("char"));
        // What is no number has no conversion to doubles.
        if let (false, Ok(values)) = (is_text, dataset.read_f64()) {
            arrays.insert(name, values);
        }
    }
    Ok(arrays)
}
