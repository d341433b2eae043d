//! Results of a sweep: means, and differences paired by seed.
//!
//! On each axis of a grid every value is compared with the first one. A pair of cells is alike in all
//! else; the differences of the pairs of one seed are averaged, so that the unit of sampling is the seed,
//! and those of the seeds go into [`Paired`]. Cells that failed, and their partners, take no part.
//! Of a random search the draws are ranked by the first metric.

use crate::folder::{CellRecord, Planned, Quantity, Status};
use crate::statistics::{Paired, deviation, holm};
use crate::sweep::{Goal, Sweep, Values};
use crate::table::{Column, Table};
use pam_numerics::statistics::mean;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;

/// One value of an axis: the mean over seeds of one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mean {
    /// The axis.
    pub axis: String,
    /// The value.
    pub value: String,
    /// The value as a number, if it is one.
    pub number: Option<f64>,
    /// The metric.
    pub metric: String,
    /// Each seed's mean over the other axes.
    pub by_seed: Vec<(u64, f64)>,
    /// Mean over seeds.
    pub mean: f64,
    /// Standard deviation over seeds.
    pub deviation: Option<f64>,
}

/// One value of an axis against the first one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The axis.
    pub axis: String,
    /// The first value.
    pub baseline: String,
    /// The other value.
    pub value: String,
    /// The metric.
    pub metric: String,
    /// Value less baseline, seed by seed.
    pub paired: Paired,
    /// `p_t` corrected for the other values of the same axis and metric (Holm).
    pub p_t_holm: Option<f64>,
}

/// A draw of a random search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Draw {
    /// Values on each axis.
    pub values: Vec<String>,
    /// The same as numbers, where they are.
    pub numbers: Vec<Option<f64>>,
    /// Mean of the first metric over seeds.
    pub mean: f64,
    /// Standard deviation over seeds.
    pub deviation: Option<f64>,
}

/// Results of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the sweep.
    pub sweep: String,
    /// Number of cells.
    pub cells: usize,
    /// Those that ended with numbers.
    pub done: usize,
    /// Those that failed.
    pub failed: usize,
    /// The metrics, those that the sweep names first.
    pub metrics: Vec<String>,
    /// Means, axis by axis; empty for a random search.
    pub means: Vec<Mean>,
    /// Differences, axis by axis; empty for a random search.
    pub differences: Vec<Difference>,
    /// Draws of a random search, the best first.
    pub draws: Vec<Draw>,
}

impl Summary {
    /// Results of cells: their metrics, or their times.
    #[must_use]
    pub fn of(
        sweep: &Sweep,
        planned: &[Planned],
        records: &[Option<CellRecord>],
        of: Quantity,
    ) -> Self {
        let with = |status| records.iter().flatten().filter(|r| r.status == status).count();
        let all = CellRecord::names(records, of);
        let mut metrics: Vec<String> =
            sweep.metrics.iter().filter(|m| all.contains(m)).cloned().collect();
        metrics.extend(all.into_iter().filter(|m| !sweep.metrics.contains(m)));
        let mut summary = Self {
            sweep: sweep.name.clone(),
            cells: planned.len(),
            done: with(Status::Done),
            failed: with(Status::Failed),
            metrics: metrics.clone(),
            means: Vec::new(),
            differences: Vec::new(),
            draws: Vec::new(),
        };
        let value = |i: usize, metric: &str| records[i].as_ref()?.value(of, metric);
        if sweep.search.is_some() {
            if let Some(first) = metrics.first() {
                summary.draws = draws(sweep, planned, &|i| value(i, first));
            }
            return summary;
        }
        for (a, axis) in sweep.axes.iter().enumerate() {
            let Values::List(variants) = &axis.values else { continue };
            for metric in &metrics {
                let found = OneAxis::new(a, planned, &|i| value(i, metric));
                for (v, variant) in variants.iter().enumerate() {
                    let by_seed = found.by_seed(v, None);
                    let values: Vec<f64> = by_seed.iter().map(|s| s.1).collect();
                    if values.is_empty() {
                        continue;
                    }
                    summary.means.push(Mean {
                        axis: axis.name.clone(),
                        value: variant.name.clone(),
                        number: planned
                            .iter()
                            .find(|p| p.cell.choices[a].index == Some(v))
                            .and_then(|p| p.cell.choices[a].number),
                        metric: metric.clone(),
                        by_seed,
                        mean: mean(&values),
                        deviation: deviation(&values),
                    });
                }
                let paired: Vec<(usize, Paired)> = (1..variants.len())
                    .filter_map(|v| {
                        let d: Vec<f64> = found.by_seed(v, Some(0)).iter().map(|s| s.1).collect();
                        Some((v, Paired::of(&d)?))
                    })
                    .collect();
                let corrected = holm(&paired.iter().map(|(_, p)| p.p_t).collect::<Vec<_>>());
                for ((v, paired), p_t_holm) in paired.into_iter().zip(corrected) {
                    summary.differences.push(Difference {
                        axis: axis.name.clone(),
                        baseline: variants[0].name.clone(),
                        value: variants[v].name.clone(),
                        metric: metric.clone(),
                        paired,
                        p_t_holm,
                    });
                }
            }
        }
        summary
    }

    /// Means and differences as a table, one row a value of an axis and metric.
    #[must_use]
    pub fn table(&self) -> Table {
        let text = |of: &dyn Fn(&Mean) -> Option<String>| {
            Column::Text(self.means.iter().map(of).collect())
        };
        let number =
            |of: &dyn Fn(&Mean) -> Option<f64>| Column::Number(self.means.iter().map(of).collect());
        let paired = |of: &dyn Fn(&Paired) -> Option<f64>| {
            number(&|m| self.difference(m).and_then(|d| of(&d.paired)))
        };
        let columns = [
            ("axis", text(&|m| Some(m.axis.clone()))),
            ("value", text(&|m| Some(m.value.clone()))),
            ("metric", text(&|m| Some(m.metric.clone()))),
            ("seeds", number(&|m| Some(m.by_seed.len() as f64))),
            ("mean", number(&|m| Some(m.mean))),
            ("deviation", number(&|m| m.deviation)),
            ("baseline", text(&|m| self.difference(m).map(|d| d.baseline.clone()))),
            ("pairs", paired(&|p| Some(p.pairs as f64))),
            ("difference", paired(&|p| Some(p.mean))),
            ("interval_low", paired(&|p| p.interval.map(|i| i[0]))),
            ("interval_high", paired(&|p| p.interval.map(|i| i[1]))),
            ("t", paired(&|p| p.t)),
            ("p_t", paired(&|p| p.p_t)),
            ("p_t_holm", number(&|m| self.difference(m).and_then(|d| d.p_t_holm))),
            ("w", paired(&|p| Some(p.w))),
            ("p_wilcoxon", paired(&|p| p.p_wilcoxon)),
        ];
        Table { columns: columns.into_iter().map(|(name, c)| (name.to_owned(), c)).collect() }
    }

    /// The difference of a value from the first one of its axis.
    #[must_use]
    pub fn difference(&self, of: &Mean) -> Option<&Difference> {
        let same =
            |d: &&Difference| d.axis == of.axis && d.value == of.value && d.metric == of.metric;
        self.differences.iter().find(same)
    }

    /// Means and differences of some metrics as Markdown tables.
    #[must_use]
    pub fn to_markdown(&self, metrics: &[String]) -> String {
        let mut out = String::new();
        let axes: Vec<&str> = self.axes();
        for axis in axes {
            for metric in metrics {
                let rows: Vec<&Mean> =
                    self.means.iter().filter(|m| m.axis == axis && m.metric == *metric).collect();
                if rows.is_empty() {
                    continue;
                }
                let _ = writeln!(
                    out,
                    "| {axis} | {metric}, mean ± SD | difference | 95 % interval | p, t | p, Wilcoxon |\n\
                     |---|---|---|---|---|---|"
                );
                for m in rows {
                    let [difference, interval, t, w] = self.difference_texts(m);
                    let _ = writeln!(
                        out,
                        "| {} | {} | {difference} | {interval} | {t} | {w} |",
                        m.value,
                        mean_text(m)
                    );
                }
                out.push('\n');
            }
        }
        out
    }

    /// Names of the axes that have means, in order.
    #[must_use]
    pub fn axes(&self) -> Vec<&str> {
        let mut axes: Vec<&str> = Vec::new();
        for m in &self.means {
            if !axes.contains(&&m.axis[..]) {
                axes.push(&m.axis);
            }
        }
        axes
    }

    /// Difference, interval, p of t and p of Wilcoxon as text; dashes for the first value.
    #[must_use]
    pub fn difference_texts(&self, of: &Mean) -> [String; 4] {
        let Some(d) = self.difference(of) else {
            return [const { String::new() }; 4].map(|_| "–".into());
        };
        let p = |p: Option<f64>| p.map_or_else(|| "–".into(), p_text);
        [
            short(d.paired.mean),
            d.paired
                .interval
                .map_or_else(|| "–".into(), |[a, b]| format!("{} to {}", short(a), short(b))),
            p(d.paired.p_t),
            p(d.paired.p_wilcoxon),
        ]
    }
}

/// Mean and deviation as text.
#[must_use]
pub fn mean_text(m: &Mean) -> String {
    let deviation = m.deviation.map_or_else(String::new, |s| format!(" ± {}", short(s)));
    format!("{}{deviation}", long(m.mean))
}

/// A number to five digits.
fn long(v: f64) -> String {
    digits(v, 5)
}

/// A number to three digits.
#[must_use]
pub fn short(v: f64) -> String {
    digits(v, 3)
}

fn digits(v: f64, digits: i32) -> String {
    let size = v.abs();
    let text = if size == 0.0 {
        "0".into()
    } else if (1e-4..1e6).contains(&size) {
        let decimals = (digits - 1 - size.log10().floor() as i32).max(0) as usize;
        format!("{v:.decimals$}")
    } else {
        format!("{v:.*e}", digits.max(1) as usize - 1)
    };
    text.replace('-', "−")
}

/// A p-value.
#[must_use]
pub fn p_text(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".into() } else { format!("{p:.4}") }
}

/// The values of one metric, by value of one axis.
struct OneAxis {
    /// (value, seed, choices on the other axes) to metric.
    values: HashMap<(usize, u64, Vec<Option<usize>>), f64>,
    seeds: Vec<u64>,
    others: Vec<Vec<Option<usize>>>,
}

impl OneAxis {
    fn new(axis: usize, planned: &[Planned], value: &dyn Fn(usize) -> Option<f64>) -> Self {
        let mut found = Self { values: HashMap::new(), seeds: Vec::new(), others: Vec::new() };
        for (i, p) in planned.iter().enumerate() {
            let mut other: Vec<Option<usize>> = p.cell.choices.iter().map(|c| c.index).collect();
            let Some(own) = other.remove(axis) else { continue };
            if !found.seeds.contains(&p.cell.seed) {
                found.seeds.push(p.cell.seed);
            }
            if !found.others.contains(&other) {
                found.others.push(other.clone());
            }
            if let Some(v) = value(i) {
                found.values.insert((own, p.cell.seed, other), v);
            }
        }
        found
    }

    /// Each seed's mean over the other axes, less that of `minus` where both are there.
    fn by_seed(&self, own: usize, minus: Option<usize>) -> Vec<(u64, f64)> {
        let get = |v: usize, seed: u64, other: &Vec<Option<usize>>| {
            self.values.get(&(v, seed, other.clone())).copied()
        };
        let mean = |seed: u64| {
            let of = |other: &Vec<Option<usize>>| {
                let value = get(own, seed, other)?;
                match minus {
                    None => Some(value),
                    Some(m) => Some(value - get(m, seed, other)?),
                }
            };
            let values: Vec<f64> = self.others.iter().filter_map(of).collect();
            (!values.is_empty()).then(|| (seed, mean(&values)))
        };
        self.seeds.iter().filter_map(|s| mean(*s)).collect()
    }
}

fn draws(sweep: &Sweep, planned: &[Planned], value: &dyn Fn(usize) -> Option<f64>) -> Vec<Draw> {
    let seeds = sweep.seeds.len();
    let mut found: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (i, p) in planned.iter().enumerate() {
        found.entry(p.cell.index / seeds).or_default().extend(value(i));
    }
    let mut draws: Vec<Draw> = found
        .into_iter()
        .filter_map(|(draw, values)| {
            if values.is_empty() {
                return None;
            }
            let choices = &planned.iter().find(|p| p.cell.index / seeds == draw)?.cell.choices;
            Some(Draw {
                values: choices.iter().map(|c| c.label.clone()).collect(),
                numbers: choices.iter().map(|c| c.number).collect(),
                mean: mean(&values),
                deviation: deviation(&values),
            })
        })
        .collect();
    draws.sort_by(|a, b| match sweep.goal {
        Goal::Max => b.mean.total_cmp(&a.mean),
        Goal::Min => a.mean.total_cmp(&b.mean),
    });
    draws
}
