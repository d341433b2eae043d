//! Checkpoints of PyTorch: a zip archive with a pickle of the objects and one file for each storage.
//!
//! The crate `pytorch-reader` (0.22) reads tensors of such files, but no NumPy arrays, and the published
//! checkpoint holds its scalers as those; hence this reader.

pub mod pickle;

use crate::error::BaselineError;
use pickle::{Node, Pickle};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// An array with its shape, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct TensorData {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Values.
    pub values: Vec<f32>,
}

/// A checkpoint that was opened.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    pickle: Pickle,
    storages: BTreeMap<String, Vec<u8>>,
}

impl Checkpoint {
    /// Opens a checkpoint that `torch.save` wrote.
    ///
    /// # Errors
    /// [`BaselineError`] if the file is no such archive.
    pub fn open(path: &Path) -> Result<Self, BaselineError> {
        let fail = |message: String| BaselineError::file(path, message);
        let bytes = std::fs::read(path)
            .map_err(|source| BaselineError::Io { path: path.to_owned(), source })?;
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes))
            .map_err(|e| fail(format!("not a PyTorch checkpoint ({e})")))?;
        let mut objects = None;
        let mut storages = BTreeMap::new();
        for i in 0..archive.len() {
            let mut file = archive.by_index(i).map_err(|e| fail(e.to_string()))?;
            let name = file.name().map_err(|e| fail(e.to_string()))?.into_owned();
            // Everything lies in one folder whose name does not matter.
            let Some((_, inner)) = name.split_once('/') else { continue };
            let mut content = Vec::new();
            file.read_to_end(&mut content).map_err(|e| fail(format!("`{name}`: {e}")))?;
            if inner == "data.pkl" {
                objects = Some(content);
            } else if inner == "byteorder" && content != b"little" {
                return Err(fail("its numbers are not little-endian".into()));
            } else if let Some(key) = inner.strip_prefix("data/") {
                storages.insert(key.to_owned(), content);
            }
        }
        let objects =
            objects.ok_or_else(|| fail("there is no data.pkl; is it a checkpoint?".into()))?;
        let pickle = Pickle::read(&objects).map_err(fail)?;
        Ok(Self { path: path.to_owned(), pickle, storages })
    }

    /// The tensors of a dictionary of the checkpoint, for example `model_state`.
    ///
    /// # Errors
    /// [`BaselineError::File`] if there is no such dictionary or a tensor is not of 32-bit floats.
    pub fn tensors(&self, dict: &str) -> Result<BTreeMap<String, TensorData>, BaselineError> {
        let p = &self.pickle;
        let dict = p
            .get(p.root(), dict)
            .ok_or_else(|| BaselineError::file(&self.path, format!("there is no `{dict}`")))?;
        p.entries(dict)
            .map(|(name, id)| {
                let tensor = self.tensor(id).map_err(|why| {
                    BaselineError::file(&self.path, format!("tensor `{name}`: {why}"))
                })?;
                Ok((name.to_owned(), tensor))
            })
            .collect()
    }

    /// A NumPy vector of 32-bit floats of the checkpoint.
    ///
    /// # Errors
    /// [`BaselineError::File`] if there is none of this name.
    pub fn vector(&self, name: &str) -> Result<Vec<f32>, BaselineError> {
        self.numpy(name).ok_or_else(|| {
            BaselineError::file(&self.path, format!("there is no vector `{name}` of 32-bit floats"))
        })
    }

    /// An integer of the checkpoint.
    #[must_use]
    pub fn int(&self, name: &str) -> Option<i64> {
        let p = &self.pickle;
        p.int(p.get(p.root(), name)?)
    }

    fn tensor(&self, id: usize) -> Result<TensorData, String> {
        let p = &self.pickle;
        let (name, arguments) = p.call(id).ok_or("it is no tensor")?;
        if name != "_rebuild_tensor_v2" || arguments.len() < 4 {
            return Err(format!("it is made by `{name}`, which is not read"));
        }
        let Node::Persistent(storage) = p.node(arguments[0]) else {
            return Err("it has no storage".into());
        };
        let storage = p.items(*storage);
        let [_, kind, key, ..] = storage else { return Err("its storage is not named".into()) };
        match p.node(*kind) {
            Node::Global(_, kind) if kind == "FloatStorage" => {}
            other => return Err(format!("its storage is {other:?}; 32-bit floats are read")),
        }
        let key = p.text(*key).ok_or("its storage is not named")?;
        let bytes = self.storages.get(key).ok_or(format!("storage `{key}` is missing"))?;
        let size = |id: usize| -> Result<usize, String> {
            usize::try_from(p.int(id).ok_or("a size is no integer")?).map_err(|e| e.to_string())
        };
        let sizes = |id: usize| -> Result<Vec<usize>, String> {
            p.items(id).iter().map(|i| size(*i)).collect()
        };
        let (offset, shape, strides) =
            (size(arguments[1])?, sizes(arguments[2])?, sizes(arguments[3])?);
        if shape.len() != strides.len() {
            return Err("shape and strides differ in length".into());
        }
        let count: usize = shape.iter().product();
        if count > bytes.len() / 4 {
            return Err("its storage is too short".into());
        }
        let mut values = Vec::with_capacity(count);
        for k in 0..count {
            let mut rest = k;
            let mut at = offset;
            for (n, stride) in shape.iter().zip(&strides).rev() {
                at += rest % n * stride;
                rest /= n;
            }
            let four = bytes.get(4 * at..4 * at + 4).ok_or("its storage is too short")?;
            values.push(f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
        }
        Ok(TensorData { shape, values })
    }

    fn numpy(&self, name: &str) -> Option<Vec<f32>> {
        let p = &self.pickle;
        let Node::Call(_, _, Some(state)) = p.node(p.get(p.root(), name)?) else { return None };
        // (version, shape, dtype, fortran, bytes); bytes are those of a text in Latin 1.
        let [_, _, dtype, _, content] = p.items(*state) else { return None };
        let (_, of) = p.call(*dtype)?;
        if p.text(*of.first()?)? != "f4" {
            return None;
        }
        let bytes: Vec<u8> = match p.node(*content) {
            Node::Bytes(bytes) => bytes.clone(),
            _ => {
                let (_, arguments) = p.call(*content)?;
                let text = p.text(*arguments.first()?)?;
                text.chars().map(|c| u8::try_from(u32::from(c)).ok()).collect::<Option<_>>()?
            }
        };
        let four = bytes.chunks_exact(4);
        Some(four.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}
