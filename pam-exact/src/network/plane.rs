/// A plane in the space of a network's inputs `(m_f, m_e, x, ẋ)`: two inputs vary, the others are fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// The fixed inputs; zero for those that vary.
    pub origin: [f64; 4],
    /// Indices of the two inputs that vary.
    pub axes: [usize; 2],
}

impl Plane {
    /// The plane of displacement (mm) and velocity (mm/s) for sealed air masses (g).
    #[must_use]
    pub fn of_motion(masses_g: [f64; 2]) -> Self {
        Self { origin: [masses_g[0], masses_g[1], 0.0, 0.0], axes: [2, 3] }
    }

    /// The plane of the two air masses (g) at a displacement (mm) and a velocity (mm/s).
    #[must_use]
    pub fn of_masses(displacement_mm: f64, velocity_mm_s: f64) -> Self {
        Self { origin: [0.0, 0.0, displacement_mm, velocity_mm_s], axes: [0, 1] }
    }
}
