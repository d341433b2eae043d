//! The hybrid model: the joint with a learned force, trained by a curriculum of [`pam_train`].

use crate::error::BaselineError;
use crate::joint::{JointBaseline, JointForce};
use crate::method::{FittedModel, Method, Structure, TrainingSet, go_on};
use num_dual::Dual64;
use pam_core::{NetworkForce, Scalar};
use pam_data::document;
use pam_data::formats::npz::Array;
use pam_train::curriculum::{Curriculum, Selection, SelectionSet};
use pam_train::training::Trainer;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// How the hybrid model is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hybrid {
    /// A curriculum that comes with [`pam_train`], or a file.
    pub curriculum: String,
    /// Single values of it, like `rate=3e-4`.
    pub set: Vec<String>,
}

impl Default for Hybrid {
    fn default() -> Self {
        Self { curriculum: "recommended".into(), set: Vec::new() }
    }
}

impl JointForce for NetworkForce<f64> {
    type Dual = NetworkForce<Dual64>;

    fn dual(&self) -> Self::Dual {
        self.map(Dual64::constant)
    }

    fn parameter_count(&self) -> usize {
        self.mlp().parameter_count()
    }

    fn structure(&self) -> Structure {
        Structure::Hybrid
    }

    fn details(&self) -> Value {
        let widths: Vec<usize> = self.mlp().layers().iter().map(|l| l.outputs()).collect();
        json!({ "outputs_of_layers": widths, "activation": self.mlp().activation().name() })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let mut arrays = BTreeMap::new();
        for (k, layer) in self.mlp().layers().iter().enumerate() {
            let shape = vec![layer.outputs() as u64, layer.inputs() as u64];
            arrays.insert(format!("W{}", k + 1), Array { shape, values: layer.weight_rows() });
            arrays.insert(format!("b{}", k + 1), Array::vector(layer.bias().to_vec()));
        }
        arrays
    }
}

impl Method for Hybrid {
    fn title(&self) -> String {
        "Hybrid neural ODE".into()
    }

    fn check(&self) -> Result<(), String> {
        Curriculum::open(&self.curriculum, &self.set).map(|_| ()).map_err(|e| e.to_string())
    }

    fn content_of_files(&self) -> Option<String> {
        let curriculum = Curriculum::open(&self.curriculum, &self.set).ok()?;
        document::to_json(&curriculum).ok()
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let mut curriculum = Curriculum::open(&self.curriculum, &self.set)?;
        // The split is the comparison's.
        curriculum.data.train = Selection::Set(SelectionSet::All);
        curriculum.data.held_out = Selection::Set(SelectionSet::None);
        let total: usize = curriculum.stages.iter().map(|s| s.epochs()).sum();
        let recordings = training.subjects.iter().map(|s| s.recording.clone()).collect();
        // Masses by the gas law, as in every prediction: the surfaces may be those of another muscle.
        let mut trainer = Trainer::new(curriculum, recordings, None, training.seed)?;
        while let Some(row) = trainer.advance()? {
            go_on(progress, row.total_epoch as f64 / total.max(1) as f64)?;
        }
        let model = trainer.model();
        let physical = model.physical();
        Ok(Box::new(JointBaseline::new(physical, model.force)?))
    }
}
