//! A correction over its variables, with the law and the coverage of the data.

use crate::remainder::Dependence;
use crate::terms::{Place, Term, TermSpace, Variable};
use serde::Serialize;

/// A correction over one variable or two, along the recordings that were fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// Name of what the terms add to, with the unit.
    pub value: String,
    /// Name of the variable with its unit.
    pub variable: String,
    /// Means in intervals of the variable.
    pub points: Vec<PicturePoint>,
    /// Means over the variable and another one.
    pub plane: Option<Plane>,
}

/// The rows of the recordings in an interval of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PicturePoint {
    /// The mean of the variable.
    pub at: f64,
    /// Mean of the correction.
    pub correction: f64,
    /// Between these values of the correction are 80 % of the rows.
    pub range: [f64; 2],
    /// Mean of the law.
    pub law: Option<f64>,
    /// Number of rows.
    pub rows: usize,
}

/// Means over two variables; where there are no data there is no cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plane {
    /// Name of the other variable with its unit.
    pub other: String,
    /// The cells with data.
    pub cells: Vec<PlaneCell>,
}

/// The rows in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PlaneCell {
    /// Middle of the cell in both variables.
    pub at: [f64; 2],
    /// Width of the cell in both variables.
    pub width: [f64; 2],
    /// Mean of the correction.
    pub correction: f64,
    /// Mean of the law.
    pub law: Option<f64>,
    /// Number of rows.
    pub rows: usize,
}

/// Intervals of a variable, and cells along each of two.
const INTERVALS: usize = 24;
const CELLS: usize = 14;
/// Most pictures.
const PICTURES: usize = 3;
/// Fewest rows in an interval or a cell that are shown.
const FEWEST: usize = 5;

/// The values of a sum of terms along recordings.
pub(super) struct Along {
    /// Index of the place.
    pub(super) place: usize,
    /// The variables, each over all recordings.
    variables: Vec<Vec<f64>>,
    correction: Vec<f64>,
    law: Option<Vec<f64>>,
}

impl Along {
    /// Correction and law along the experiments, at the place where the law acts, or the correction does without one.
    pub(super) fn of(
        space: &dyn TermSpace,
        experiments: &[usize],
        correction: &[Term],
        law: Option<&[Term]>,
    ) -> Option<Self> {
        let place = law.unwrap_or(correction).first()?.place;
        let smooth = |p: &Place| p.dry.is_some_and(|(dry, _)| dry == place);
        let place = space.places().iter().position(smooth).unwrap_or(place);
        let mut all = Self {
            place,
            variables: vec![Vec::new(); space.variables().len()],
            correction: Vec::new(),
            law: law.map(|_| Vec::new()),
        };
        for &e in experiments {
            let (series, step_s) = (space.series(e), space.step_s(e));
            let sum = |terms: &[Term]| sum(terms, place, space.places(), &series, step_s);
            all.correction.extend(sum(correction));
            if let (Some(all), Some(terms)) = (&mut all.law, law) {
                all.extend(sum(terms));
            }
            for (all, own) in all.variables.iter_mut().zip(series) {
                all.extend(own);
            }
        }
        Some(all)
    }

    /// Share of the variation of the correction that is the law's, from 0 to 1.
    pub(super) fn similarity(&self) -> Option<f64> {
        let law = self.law.as_ref()?;
        let mean = pam_numerics::statistics::mean(&self.correction);
        let rest: f64 = self.correction.iter().zip(law).map(|(c, l)| (c - l).powi(2)).sum();
        let whole: f64 = self.correction.iter().map(|c| (c - mean).powi(2)).sum();
        Some((1.0 - rest / whole.max(f64::MIN_POSITIVE)).max(0.0))
    }

    /// Pictures over the variables that matter most.
    pub(super) fn pictures(
        &self,
        variables: &[Variable],
        place: &Place,
        depends_on: &[Dependence],
        law: Option<&[Term]>,
    ) -> Vec<Picture> {
        let of_law: Vec<usize> = law.into_iter().flatten().flat_map(Term::variables).collect();
        let mut chosen: Vec<usize> = Vec::new();
        let by_group =
            depends_on.iter().filter_map(|d| variables.iter().position(|v| v.group == d.on));
        for k in of_law.into_iter().chain(by_group) {
            let group = |k: usize| &variables[k].group;
            if place.variables.contains(&k) && !chosen.iter().any(|&c| group(c) == group(k)) {
                chosen.push(k);
            }
        }
        chosen.truncate(PICTURES);
        let value = labelled(&place.name, &place.unit_text);
        chosen
            .iter()
            .enumerate()
            .map(|(i, &k)| Picture {
                value: value.clone(),
                variable: label(&variables[k]),
                points: self.points(k),
                plane: (i == 0 && chosen.len() > 1).then(|| self.plane([k, chosen[1]], variables)),
            })
            .collect()
    }

    fn points(&self, variable: usize) -> Vec<PicturePoint> {
        let u = &self.variables[variable];
        let (low, width) = grid(u, INTERVALS);
        let mut bins: Vec<Vec<usize>> = vec![Vec::new(); INTERVALS];
        for (row, &value) in u.iter().enumerate() {
            bins[cell(value, low, width, INTERVALS)].push(row);
        }
        let mean = |rows: &[usize], values: &[f64]| {
            rows.iter().map(|&k| values[k]).sum::<f64>() / rows.len() as f64
        };
        let shown = bins.iter().filter(|rows| rows.len() >= FEWEST);
        shown
            .map(|rows| {
                let own: Vec<f64> = rows.iter().map(|&k| self.correction[k]).collect();
                let at = |share| pam_numerics::statistics::quantile(&own, share);
                PicturePoint {
                    at: mean(rows, u),
                    correction: mean(rows, &self.correction),
                    range: [at(0.1), at(0.9)],
                    law: self.law.as_ref().map(|law| mean(rows, law)),
                    rows: rows.len(),
                }
            })
            .collect()
    }

    fn plane(&self, [a, b]: [usize; 2], variables: &[Variable]) -> Plane {
        let (x, y) = (&self.variables[a], &self.variables[b]);
        let ((x0, dx), (y0, dy)) = (grid(x, CELLS), grid(y, CELLS));
        let mut sums = vec![(0.0, 0.0, 0_usize); CELLS * CELLS];
        for row in 0..x.len() {
            let place = cell(x[row], x0, dx, CELLS) * CELLS + cell(y[row], y0, dy, CELLS);
            let (correction, law, rows) = &mut sums[place];
            *correction += self.correction[row];
            *law += self.law.as_ref().map_or(0.0, |law| law[row]);
            *rows += 1;
        }
        let shown = sums.iter().enumerate().filter(|(_, s)| s.2 >= FEWEST);
        let middle = |from: f64, width: f64, k: usize| from + (k as f64 + 0.5) * width;
        let cells = shown.map(|(k, &(correction, law, rows))| PlaneCell {
            at: [middle(x0, dx, k / CELLS), middle(y0, dy, k % CELLS)],
            width: [dx, dy],
            correction: correction / rows as f64,
            law: self.law.as_ref().map(|_| law / rows as f64),
            rows,
        });
        Plane { other: label(&variables[b]), cells: cells.collect() }
    }
}

/// The terms at a place, and dry friction as the force that it is while the joint slides.
fn sum(
    terms: &[Term],
    place: usize,
    places: &[Place],
    series: &[Vec<f64>],
    step_s: f64,
) -> Vec<f64> {
    let mut sum = vec![0.0; series.first().map_or(0, Vec::len)];
    for term in terms {
        let values = term.series(series, step_s);
        let dry = places[place].dry.filter(|(dry, _)| *dry == term.place);
        if let Some((_, velocity)) = dry {
            let slides = series[velocity].iter().map(|v| -v.signum());
            sum.iter_mut().zip(values).zip(slides).for_each(|((s, v), d)| *s += d * v.max(0.0));
        } else if term.place == place {
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
        }
    }
    sum
}

/// Lower end and width of intervals over a variable.
fn grid(values: &[f64], count: usize) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (low, ((high - low) / count as f64).max(f64::MIN_POSITIVE))
}

fn cell(value: f64, low: f64, width: f64, count: usize) -> usize {
    (((value - low) / width) as usize).min(count - 1)
}

fn label(variable: &Variable) -> String {
    labelled(&variable.name, &variable.unit_text)
}

fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "–" { name.to_owned() } else { format!("{name} ({unit})") }
}
