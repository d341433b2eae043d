use super::{Tableau, hermite};

impl Tableau {
    /// The classical fourth-order method (Kutta 1901), cubic Hermite interpolant, no error estimate.
    #[must_use]
    pub fn rk4() -> Self {
        let b = vec![1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];
        Self {
            name: "rk4",
            order: 4,
            embedded_order: None,
            interpolant_order: 3,
            c: vec![0.0, 0.5, 0.5, 1.0],
            a: vec![vec![], vec![0.5], vec![0.0, 0.5], vec![0.0, 0.0, 1.0]],
            interpolant: hermite(&b),
            b,
            error: None,
        }
    }
}
