use super::{Tableau, hermite};

impl Tableau {
    /// Bogacki–Shampine 3(2) with its cubic Hermite interpolant.
    ///
    /// Source: P. Bogacki and L. F. Shampine, *A 3(2) pair of Runge–Kutta formulas*, Applied
    /// Mathematics Letters 2 (1989) 321–325.
    #[must_use]
    pub fn bogacki_shampine3() -> Self {
        let b = vec![2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0];
        Self {
            name: "bs3",
            order: 3,
            embedded_order: Some(2),
            interpolant_order: 3,
            c: vec![0.0, 0.5, 0.75],
            a: vec![vec![], vec![0.5], vec![0.0, 0.75]],
            // b − b̂ with b̂ = [7/24, 1/4, 1/3, 1/8].
            error: Some(vec![-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0]),
            interpolant: hermite(&b),
            b,
        }
    }
}
