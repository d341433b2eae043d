//! The cells of a sweep.

use super::{Assignment, Range, Sweep, Values};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Value of a cell on one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Place in the list of the axis; absent for a draw from a range.
    pub index: Option<usize>,
    /// Its name.
    pub label: String,
    /// Its value, if it is one number.
    pub number: Option<f64>,
}

/// One run of the experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Place among all cells; shards share cells out by it.
    pub index: usize,
    /// The seed.
    pub seed: u64,
    /// Values on each axis.
    pub choices: Vec<Choice>,
    /// All keys that are set, in the order in which they are: those of all cells, then axis by axis.
    pub assignments: Vec<Assignment>,
}

impl Cell {
    /// The choices and the seed in a line.
    #[must_use]
    pub fn describe(&self, sweep: &Sweep) -> String {
        let pair =
            |(axis, choice): (&super::Axis, &Choice)| format!("{} = {}", axis.name, choice.label);
        let mut parts: Vec<String> = sweep.axes.iter().zip(&self.choices).map(pair).collect();
        parts.push(format!("seed {}", self.seed));
        parts.join(", ")
    }
}

/// Most cells of a sweep: a year of trainings of five minutes.
pub const MOST_CELLS: usize = 100_000;

impl Sweep {
    /// Number of cells; of a random search that of draws, which may be alike.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        let points = match self.search {
            Some(search) => search.draws,
            None => self.axes.iter().fold(1, |product: usize, axis| match &axis.values {
                Values::List(variants) => product.saturating_mul(variants.len()),
                Values::Range(..) => product,
            }),
        };
        points.saturating_mul(self.seeds.len())
    }

    /// All cells: seeds vary fastest, then the last axis.
    #[must_use]
    pub fn cells(&self) -> Vec<Cell> {
        let points = match self.search {
            None => self.grid(),
            Some(search) => {
                let mut random = ChaCha8Rng::seed_from_u64(search.seed);
                (0..search.draws).map(|_| self.draw(&mut random)).collect()
            }
        };
        let mut cells = Vec::with_capacity(points.len() * self.seeds.len());
        for (choices, set) in points {
            for &seed in &self.seeds {
                cells.push(Cell {
                    index: cells.len(),
                    seed,
                    choices: choices.clone(),
                    assignments: self.set.iter().chain(&set).cloned().collect(),
                });
            }
        }
        cells
    }

    fn grid(&self) -> Vec<(Vec<Choice>, Vec<Assignment>)> {
        let mut points = vec![(Vec::new(), Vec::new())];
        for axis in &self.axes {
            let Values::List(variants) = &axis.values else { continue };
            points = points
                .iter()
                .flat_map(|(choices, set): &(Vec<Choice>, Vec<Assignment>)| {
                    variants.iter().enumerate().map(move |(i, v)| {
                        let (mut choices, mut set) = (choices.clone(), set.clone());
                        choices.push(listed(i, v));
                        set.extend(v.set.iter().cloned());
                        (choices, set)
                    })
                })
                .collect();
        }
        points
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> (Vec<Choice>, Vec<Assignment>) {
        let (mut choices, mut set) = (Vec::new(), Vec::new());
        for axis in &self.axes {
            match &axis.values {
                Values::List(variants) => {
                    let i = random.random_range(0..variants.len());
                    choices.push(listed(i, &variants[i]));
                    set.extend(variants[i].set.iter().cloned());
                }
                Values::Range(key, range) => {
                    let value = match *range {
                        Range::Uniform(a, b) => {
                            toml::Value::Float(a + (b - a) * random.random::<f64>())
                        }
                        Range::LogUniform(a, b) => toml::Value::Float(
                            (a.ln() + (b.ln() - a.ln()) * random.random::<f64>()).exp(),
                        ),
                        Range::Integers(a, b) => toml::Value::Integer(random.random_range(a..=b)),
                    };
                    choices.push(Choice {
                        index: None,
                        label: value.to_string(),
                        number: number_of(&value),
                    });
                    set.push(Assignment { key: key.clone(), value, line: axis.line });
                }
            }
        }
        (choices, set)
    }
}

fn listed(index: usize, variant: &super::Variant) -> Choice {
    let number = match &variant.set[..] {
        [only] => number_of(&only.value),
        _ => None,
    };
    Choice { index: Some(index), label: variant.name.clone(), number }
}

fn number_of(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}
