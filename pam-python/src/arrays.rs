//! Arrays in and out.

use numpy::ndarray::{Array2, ArrayView1, IxDyn};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// A read-only array over numbers that belong to `owner`, without a copy.
///
/// `owner` must be an immutable (frozen) object that holds the numbers: they live and stay where they are as long as the array
/// holds a reference to it.
pub(crate) fn view<'py>(owner: &Bound<'py, PyAny>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    // SAFETY: the array keeps `owner` alive, and `owner` neither moves nor changes `values` (see above). The array is made
    // read-only, so that Python does not change them either.
    #[allow(unsafe_code)]
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner.clone()) };
    array.readwrite().make_nonwriteable();
    array
}

/// Rows as an array `[rows, N]`.
pub(crate) fn rows<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[f64; N]],
) -> Bound<'py, PyArray2<f64>> {
    let flat = rows.iter().flatten().copied().collect();
    Array2::from_shape_vec((rows.len(), N), flat).expect("N numbers per row").into_pyarray(py)
}

/// A tensor as an array of its shape.
pub(crate) fn tensor<'py>(
    py: Python<'py>,
    shape: &[usize],
    values: Vec<f64>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    PyArray1::from_vec(py, values).reshape(IxDyn(shape))
}

/// The rows of an array `[rows, N]`.
pub(crate) fn to_rows<const N: usize>(
    what: &str,
    array: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<[f64; N]>> {
    let view = array.as_array();
    if view.ncols() != N {
        return Err(crate::errors::settings(format!(
            "`{what}` has shape {:?}; it must be [recordings, {N}]",
            view.shape()
        )));
    }
    Ok(view.outer_iter().map(|row| std::array::from_fn(|i| row[i])).collect())
}
