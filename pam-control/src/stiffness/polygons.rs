use pam_core::{AnyForce, JointModel, SealedMasses};
use pam_exact::{Partition, Plane, ReluNetwork, Window};

/// Most polygons of a map.
const MOST_POLYGONS: usize = 200_000;

/// Stiffness and damping over displacement and velocity as polygons: all linear regions of a ReLU network.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactMap {
    /// Title of the map.
    pub name: String,
    /// The air in the muscles.
    pub masses: SealedMasses,
    /// Auxiliary damping B that adds to that of the force, kg/s.
    pub auxiliary_damping_kg_s: f64,
    /// The polygons: `force[1]` is the stiffness in mN/mm, `force[2]` the damping of the force in kg/s.
    pub partition: Partition,
}

impl ExactMap {
    /// The polygons within `±reach` (mm, mm/s); `None` if the force is not a (leaky) ReLU network.
    #[must_use]
    pub fn new(
        model: &JointModel<f64, AnyForce<f64>>,
        name: String,
        masses: SealedMasses,
        reach: [f64; 2],
    ) -> Option<Self> {
        let network = ReluNetwork::new(&model.force).ok()?;
        let plane = Plane::of_motion([masses.flexor_g, masses.extensor_g]);
        let window = Window { first: [-reach[0], reach[0]], second: [-reach[1], reach[1]] };
        let partition = Partition::new(&network, plane, window, MOST_POLYGONS);
        let auxiliary_damping_kg_s = model.auxiliary_damping_kg_s;
        Some(Self { name, masses, auxiliary_damping_kg_s, partition })
    }
}
