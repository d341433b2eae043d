use crate::regions::Window;

/// The motion and the stiffness wanted at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InverseProblem {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// The restoring force f that the motion needs, mN: `F_e − m ẍ − B ẋ`.
    pub force_mn: f64,
    /// Wanted stiffness, mN/mm.
    pub stiffness_mn_mm: f64,
    /// Step h of the stiffness estimate, mm.
    pub step_mm: f64,
    /// Bounds of m_f and m_e, g.
    pub bounds: Window,
}

/// The proof that a solution is the global optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// Linear regions of the mass plane within the bounds.
    pub regions: usize,
    /// The share of the bounds' area that they leave uncovered, of either sign; zero to rounding.
    pub uncovered_share: f64,
    /// Straight segments of the curve of consistent masses.
    pub segments: usize,
    /// Pieces of those on which K̂ is affine.
    pub pieces: usize,
}

impl Certificate {
    /// True if the regions fill the bounds, up to a share of 1e-9.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.uncovered_share.abs() < 1e-9
    }
}

/// The optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InverseSolution {
    /// m_f and m_e, g.
    pub masses_g: [f64; 2],
    /// K̂ there, mN/mm.
    pub stiffness_mn_mm: f64,
    /// The force there less the wanted one, mN: zero to rounding unless the motion is out of reach.
    pub residual_mn: f64,
    /// Smallest and largest K̂ of all consistent masses, mN/mm; none if the motion is out of reach.
    pub reachable_mn_mm: Option<[f64; 2]>,
    /// The proof.
    pub certificate: Certificate,
}
