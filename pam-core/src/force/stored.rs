//! Force models as plain parts, for files.

use crate::error::ModelError;

/// A named array of numbers, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Values, last dimension fastest.
    pub values: Vec<f64>,
}

/// A force model taken apart: named tensors and named settings, in a fixed order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceParts {
    /// Numbers.
    pub tensors: Vec<(String, Tensor)>,
    /// Everything else, as text.
    pub settings: Vec<(String, String)>,
}

impl ForceParts {
    /// Adds a tensor.
    ///
    /// # Panics
    /// If the number of values is not that of the shape.
    pub fn push_tensor(&mut self, name: impl Into<String>, shape: Vec<usize>, values: Vec<f64>) {
        assert_eq!(shape.iter().product::<usize>(), values.len(), "a tensor fits its shape");
        self.tensors.push((name.into(), Tensor { shape, values }));
    }

    /// The tensor of this name, if there is one.
    #[must_use]
    pub fn tensor(&self, name: &str) -> Option<&Tensor> {
        self.tensors.iter().find(|(n, _)| n == name).map(|(_, t)| t)
    }

    /// The tensor of this name.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if it is missing.
    pub fn require(&self, name: &str) -> Result<&Tensor, ModelError> {
        self.tensor(name).ok_or_else(|| ModelError::Shape(format!("tensor `{name}` is missing")))
    }

    /// A vector of `N` numbers.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if it is missing or of another length.
    pub fn vector<const N: usize>(&self, name: &str) -> Result<[f64; N], ModelError> {
        let tensor = self.require(name)?;
        tensor.values.as_slice().try_into().map_err(|_| {
            ModelError::Shape(format!("tensor `{name}` has shape {:?}, not [{N}]", tensor.shape))
        })
    }

    /// The setting of this name, if there is one.
    #[must_use]
    pub fn setting(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
}

/// A force model that can be stored in a file and described in a report.
pub trait StoredForce: Sized {
    /// The model taken apart.
    fn to_parts(&self) -> ForceParts;

    /// The model put together again.
    ///
    /// # Errors
    /// [`ModelError`] naming the part that is missing or wrong.
    fn from_parts(parts: &ForceParts) -> Result<Self, ModelError>;

    /// The model in a few words.
    fn describe(&self) -> String;

    /// The force times a factor, if the model's numbers can hold that.
    #[must_use]
    fn scaled(&self, factor: f64) -> Option<Self> {
        let _ = factor;
        None
    }

    /// The force with a constant (mN) added, if the model's numbers can hold that.
    #[must_use]
    fn shifted(&self, offset_mn: f64) -> Option<Self> {
        let _ = offset_mn;
        None
    }
}
