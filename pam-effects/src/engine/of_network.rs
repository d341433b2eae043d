//! The engines of any force for a network.

use pam_core::{AnyForce, JointModel, NetworkForce};
use pam_trajectory::engine::{
    EngineError, IndexedLoss, Precision, TrajectoryEngine, TrajectoryGradient, TrajectoryRequest,
};

/// An engine for [`AnyForce`] that takes models with a network, so that engines are compiled for one type. A call copies the
/// weights once.
#[derive(Debug)]
pub(super) struct OfNetwork(pub(super) Box<dyn TrajectoryEngine<AnyForce<f64>>>);

impl TrajectoryEngine<NetworkForce<f64>> for OfNetwork {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        let JointModel { raw, geometry, auxiliary_damping_kg_s, force } = request.model.clone();
        let force = AnyForce::from(force);
        let model = JointModel { raw, geometry, auxiliary_damping_kg_s, force };
        let TrajectoryRequest { effects, windows, part, starts, progress, .. } = *request;
        let request = TrajectoryRequest { model: &model, effects, windows, part, starts, progress };
        self.0.evaluate(&request, loss, backward)
    }

    fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        self.0.predicted(index)
    }

    fn precision(&self) -> Precision {
        self.0.precision()
    }
}
