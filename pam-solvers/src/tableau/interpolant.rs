use super::Tableau;

/// Numbers that are computed at once.
const WIDTH: usize = 8;

/// The interpolation polynomials of a method, laid out so that the weights of all stages are
/// evaluated together. For reading many points of many steps; the weights are those of
/// [`Tableau::interpolation_weight`].
#[derive(Debug, Clone, Default)]
pub(crate) struct InterpolantTable {
    /// Per power of θ, highest first, one coefficient per stage, padded to whole groups.
    coefficients: Vec<[f64; WIDTH]>,
    groups: usize,
}

impl InterpolantTable {
    /// The table of a method.
    pub(crate) fn new(tableau: &Tableau) -> Self {
        let groups = tableau.stages_with_fsal().div_ceil(WIDTH);
        let powers = tableau.interpolant.iter().map(Vec::len).max().unwrap_or(0);
        let mut coefficients = vec![[0.0; WIDTH]; powers * groups];
        for (i, polynomial) in tableau.interpolant.iter().enumerate() {
            for (power, &c) in polynomial.iter().enumerate() {
                coefficients[(powers - 1 - power) * groups + i / WIDTH][i % WIDTH] = c;
            }
        }
        Self { coefficients, groups }
    }

    /// Length of the buffer that [`weights_into`](Self::weights_into) fills.
    pub(crate) fn len(&self) -> usize {
        self.groups * WIDTH
    }

    /// Writes `h b_i(θ)` for every stage; entries past the last stage are zero.
    ///
    /// # Panics
    /// If the buffer is not of length [`len`](Self::len).
    #[inline]
    pub(crate) fn weights_into(&self, theta: f64, h: f64, weights: &mut [f64]) {
        let (weights, _) = weights.as_chunks_mut::<WIDTH>();
        assert_eq!(weights.len(), self.groups, "one weight for each stage");
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

    #[test]
    fn the_table_holds_the_polynomials() {
        for name in Tableau::NAMES {
            let tableau = Tableau::from_name(name).unwrap();
            let table = InterpolantTable::new(&tableau);
            let mut weights = vec![f64::NAN; table.len()];
            for theta in [0.0, 0.13, 0.5, 0.99, 1.0] {
                table.weights_into(theta, 0.2, &mut weights);
                for (i, &w) in weights.iter().enumerate() {
                    let exact = if i < tableau.stages_with_fsal() {
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
