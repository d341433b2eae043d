//! The gas law of a recording, as a table.

use super::gas::Chambers;
use pam_core::Scalar;

/// Largest distance of two nodes, mm: a thirtieth of the largest error with the published geometry.
const SPACING_MM: f64 = 0.1;
/// Most cells; a longer range has none.
const MOST_CELLS: usize = 256;
/// Share of the measured range by which the table goes beyond it on either side, so that most simulations stay inside.
const BEYOND: f64 = 0.25;
/// Further margin, mm.
const MARGIN_MM: f64 = 0.5;
/// Share of the displacement at which a chamber has no volume that the table may reach: close to it the pressure is steep.
const REACH: f64 = 0.9;
/// Largest relative error of a table; with more, the law itself is computed.
const LARGEST_ERROR: f64 = 1e-9;

/// Number of tabulated functions: pressure per mass of flexor and extensor, and the feedback.
const FUNCTIONS: usize = 3;
/// Number of coefficients of a cubic.
const COEFFICIENTS: usize = 4;

/// Pressures per mass and feedback of [`Chambers`] with given masses over the displacement, as a cubic in each cell through
/// four nodes about it. A law with logarithms and powers is computed at some hundred nodes in place of every stage of every step.
#[derive(Debug, Clone)]
pub(super) struct GasTable<S> {
    start_mm: f64,
    per_mm: f64,
    cells: Vec<[[S; COEFFICIENTS]; FUNCTIONS]>,
}

impl<S: Scalar> GasTable<S> {
    /// Tabulates a law where the displacement stays in about this range, mm; `None` where cubics do not hold it.
    pub(super) fn new(
        chambers: &Chambers<'_, S>,
        air_g: [S; 2],
        [low, high]: [f64; 2],
        limit_mm: f64,
    ) -> Option<Self> {
        let margin = BEYOND * (high - low) + MARGIN_MM;
        let within = |x: f64| x.clamp(-REACH * limit_mm, REACH * limit_mm);
        let (low, high) = (within(low - margin), within(high + margin));
        let cells = ((high - low) / SPACING_MM).ceil();
        if !(1.0..=MOST_CELLS as f64).contains(&cells) {
            return None;
        }
        let step_mm = (high - low) / cells;
        let at = |k: f64| functions(chambers, air_g, S::constant(low + k * step_mm));
        // One node beyond on either side: the cells at the ends have neighbours as well.
        let nodes: Vec<[S; FUNCTIONS]> =
            (0..cells as usize + 3).map(|k| at(k as f64 - 1.0)).collect();
        let table = Self {
            start_mm: low,
            per_mm: step_mm.recip(),
            cells: nodes
                .windows(4)
                .map(|n| std::array::from_fn(|q| cubic([0, 1, 2, 3].map(|k| n[k][q]))))
                .collect(),
        };
        table.holds(chambers, air_g, step_mm).then_some(table)
    }

    /// Compares the interpolation error at the midpoint of each cell with the tolerance.
    fn holds(&self, chambers: &Chambers<'_, S>, air_g: [S; 2], step_mm: f64) -> bool {
        (0..self.cells.len()).all(|k| {
            let x = S::constant(self.start_mm + (k as f64 + 0.5) * step_mm);
            let exact = functions(chambers, air_g, x);
            let largest =
                |q: usize| self.cells.iter().map(|c| c[q][0].real().abs()).fold(0.0, f64::max);
            (0..FUNCTIONS).all(|q| {
                let found = self.at(q, &x).map_or(f64::NAN, |value| value.real());
                (found - exact[q].real()).abs() <= LARGEST_ERROR * largest(q)
            })
        })
    }

    /// Pressures of flexor and extensor per mass, kPa/g; `None` outside the table.
    #[inline(always)]
    pub(super) fn pressures_per_mass(&self, x: &S) -> Option<[S; 2]> {
        Some([self.at(0, x)?, self.at(1, x)?])
    }

    /// The feedback, mN; `None` outside the table.
    #[inline(always)]
    pub(super) fn feedback_mn(&self, x: &S) -> Option<S> {
        self.at(2, x)
    }

    #[inline(always)]
    fn at(&self, function: usize, x: &S) -> Option<S> {
        let position = (x.real() - self.start_mm) * self.per_mm;
        if !(position >= 0.0 && position < self.cells.len() as f64) {
            return None;
        }
        let cell = position as usize;
        let t = position - cell as f64;
        let [a, b, c, d] = &self.cells.get(cell)?[function];
        let (second, third) = (t * t, t * t * t);
        let [b0, c0, d0] = [b, c, d].map(|k| k.real());
        let value = a.real() + b0 * t + c0 * second + d0 * third;
        let slope = (b0 + 2.0 * c0 * t + 3.0 * d0 * second) * self.per_mm;
        Some(S::with_slopes(value, [a, b, c, d, x], [1.0, t, second, third, slope]))
    }
}

fn functions<S: Scalar>(chambers: &Chambers<'_, S>, air_g: [S; 2], x: S) -> [S; FUNCTIONS] {
    let [flexor, extensor] = chambers.pressures_per_mass(x);
    [flexor, extensor, chambers.feedback_mn(x, air_g)]
}

/// The cubic through values at −1, 0, 1 and 2, by its coefficients about 0.
fn cubic<S: Scalar>([before, start, end, after]: [S; 4]) -> [S; COEFFICIENTS] {
    let all = [&before, &start, &end, &after];
    [
        start,
        S::combination(all, [-1.0 / 3.0, -0.5, 1.0, -1.0 / 6.0]),
        S::combination(all, [0.5, -1.0, 0.5, 0.0]),
        S::combination(all, [-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::ChamberLaw;
    use crate::simulation::Base;
    use pam_autodiff::Chunk;
    use pam_core::MuscleGeometry;

    /// Directions: the exponent and the displacement.
    type Number = Chunk<2>;

    #[test]
    fn a_table_is_the_law_with_its_derivatives() {
        let constant = Number::constant;
        let base = Base {
            mass_kg: constant(2.0),
            deformation: constant(1.7),
            gas_coefficient: constant(8.4e4),
            damping_kg_s: constant(0.0),
            geometry: MuscleGeometry::default(),
        };
        let exponent = Number::variable(1.2, 0);
        let law = ChamberLaw { exponent, feeds_back: true, ..ChamberLaw::plain() };
        let chambers = Chambers::new(&base, law, true, constant(0.3));
        let air_g = [0.05, 0.06].map(constant);
        let limit_mm = base.geometry.displacement_limit_mm(1.7);
        let table = GasTable::new(&chambers, air_g, [-2.0, 4.0], limit_mm).expect("a smooth law");
        for k in 0..600 {
            let x = Number::variable(-2.0 + 0.01 * f64::from(k), 1);
            let [flexor, extensor] = table.pressures_per_mass(&x).expect("inside");
            let found = [flexor, extensor, table.feedback_mn(&x).expect("inside")];
            let pairs = found.into_iter().zip(functions(&chambers, air_g, x));
            for ((found, exact), scale) in pairs.zip([5.0, 5.0, 1.0]) {
                assert!((found.value - exact.value).abs() < 1e-9 * scale, "{k}");
                for (a, b) in found.derivatives.iter().zip(exact.derivatives) {
                    assert!((a - b).abs() < 1e-6 * scale, "{k}: {a} {b}");
                }
            }
        }
        assert!(
            table.feedback_mn(&constant(20.0)).is_none(),
            "outside, the law itself is computed"
        );
    }
}
