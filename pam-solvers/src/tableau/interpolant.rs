use super::Tableau;

/// Numbers that are computed at once.
const WIDTH: usize = 8;

/// The interpolation polynomials of a method, laid out so that the weights of all derivatives are
/// evaluated together. For reading many points of many steps; the weights are those of
/// [`Tableau::interpolation_weight`].
#[derive(Debug, Clone)]
pub struct InterpolantTable {
    derivatives: usize,
    /// Per power of θ, highest first, one coefficient a derivative, padded to whole groups.
    coefficients: Vec<[f64; WIDTH]>,
    groups: usize,
}

impl InterpolantTable {
    /// The table of a method.
    #[must_use]
    pub fn new(tableau: &Tableau) -> Self {
        let derivatives = tableau.derivatives();
        let groups = derivatives.div_ceil(WIDTH);
        let powers = tableau.interpolant.iter().map(Vec::len).max().unwrap_or(0);
        let mut coefficients = vec![[0.0; WIDTH]; powers * groups];
        for (i, polynomial) in tableau.interpolant.iter().enumerate() {
            for (power, &c) in polynomial.iter().enumerate() {
                coefficients[(powers - 1 - power) * groups + i / WIDTH][i % WIDTH] = c;
            }
        }
        Self { derivatives, coefficients, groups }
    }

    /// Length of the buffer that [`weights_into`](Self::weights_into) fills.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups * WIDTH
    }

    /// Whether the method has no derivatives at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.derivatives == 0
    }

    /// Writes `h b_i(θ)` for every derivative; entries past the last derivative are zero.
    ///
    /// # Panics
    /// If the buffer is not of length [`len`](Self::len).
    #[inline]
    pub fn weights_into(&self, theta: f64, h: f64, weights: &mut [f64]) {
        let (weights, _) = weights.as_chunks_mut::<WIDTH>();
        assert_eq!(weights.len(), self.groups, "one weight for each derivative");
        for (group, weights) in weights.iter_mut().enumerate() {
            let mut sums = [0.0; WIDTH];
            for c in self.coefficients.iter().skip(group).step_by(self.groups) {
                for i in 0..WIDTH {
                    sums[i] = (sums[i] + c[i]) * theta;
                }
            }
            *weights = sums.map(|sum| h * sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tableau::NAMES;

    #[test]
    fn the_table_holds_the_polynomials() {
        for name in NAMES {
            let tableau = Tableau::from_name(name).unwrap();
            let table = InterpolantTable::new(&tableau);
            let mut weights = vec![f64::NAN; table.len()];
            for theta in [0.0, 0.13, 0.5, 0.99, 1.0] {
                table.weights_into(theta, 0.2, &mut weights);
                for (i, &w) in weights.iter().enumerate() {
                    let exact = if i < tableau.derivatives() {
                        0.2 * tableau.interpolation_weight(i, theta)
                    } else {
                        0.0
                    };
                    assert_eq!(w, exact, "{name} {i} {theta}");
                }
            }
        }
    }
}
