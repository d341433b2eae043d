//! On which variables a correction depends.

use super::result::Dependence;
use crate::law::Design;
use crate::terms::{Term, Variable};
use pam_numerics::statistics::{mean, mean_half_width_95, paired_t_test};
use pam_numerics::{ScaledCholesky, dot};

/// Inner products of the columns of one block of time, and with the target.
struct Block {
    gram: Vec<f64>,
    right: Vec<f64>,
    square: f64,
}

/// Leaves out the terms of each group of variables in turn. The coefficients are fitted to some blocks of time and judged on
/// the others, to first order about the correction. `fixed` parameters of the design stand before those of the terms, whose
/// priors have this standard deviation.
pub(crate) fn dependence(
    design: &Design,
    blocks: &[Vec<std::ops::Range<usize>>],
    fixed: usize,
    terms: &[&Term],
    deviation: f64,
    variables: &[Variable],
    folds: usize,
) -> Vec<Dependence> {
    let n = design.own.len();
    let of = |ranges: &[std::ops::Range<usize>]| {
        let product = |a: &[f64], b: &[f64]| -> f64 {
            ranges.iter().map(|r| dot(&a[r.clone()], &b[r.clone()])).sum()
        };
        let mut gram = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                gram[i * n + j] = product(&design.own[i], &design.own[j]);
                gram[j * n + i] = gram[i * n + j];
            }
        }
        let right = design.own.iter().map(|c| product(c, &design.target)).collect();
        Block { gram, right, square: product(&design.target, &design.target) }
    };
    let blocks: Vec<Block> = blocks.iter().map(|b| of(b)).collect();
    // Of each block what is left by parameters that are fitted to the blocks of the other folds.
    let left = |kept: &[usize]| -> Option<Vec<f64>> {
        let mut all = vec![0.0; blocks.len()];
        for fold in 0..folds.min(blocks.len()) {
            let others =
                || blocks.iter().enumerate().filter(|(b, _)| b % folds != fold).map(|b| b.1);
            let prior = |k: usize| if k < fixed { 0.0 } else { deviation.powi(-2) };
            let entry = |i: usize, j: usize| {
                let sum: f64 = others().map(|b| b.gram[kept[i] * n + kept[j]]).sum();
                sum + if i == j { prior(kept[i]) } else { 0.0 }
            };
            let right: Vec<f64> =
                kept.iter().map(|&k| others().map(|b| b.right[k]).sum()).collect();
            let c = ScaledCholesky::new(kept.len(), entry, 1e-10)?.solve(&right)?;
            for (b, block) in blocks.iter().enumerate().filter(|(b, _)| b % folds == fold) {
                let mut square = block.square;
                for (i, &k) in kept.iter().enumerate() {
                    let row: f64 =
                        kept.iter().zip(&c).map(|(&j, c)| block.gram[k * n + j] * c).sum();
                    square += c[i] * (row - 2.0 * block.right[k]);
                }
                all[b] = square.max(0.0);
            }
        }
        Some(all)
    };
    let every: Vec<usize> = (0..n).collect();
    let Some(whole) = left(&every) else { return Vec::new() };
    let size = mean(&whole).max(f64::MIN_POSITIVE);
    let mut groups: Vec<&str> = Vec::new();
    for term in terms {
        for k in term.variables() {
            let group = variables[k].group.as_str();
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
    }
    let memory = "memory";
    if terms.iter().any(|t| t.remembers()) {
        groups.push(memory);
    }
    let mut all: Vec<Dependence> = groups
        .iter()
        .filter_map(|group| {
            let holds = |t: &Term| {
                (*group == memory && t.remembers())
                    || t.variables().iter().any(|k| variables[*k].group == *group)
            };
            let own = terms.iter().enumerate().filter(|(_, t)| !holds(t)).map(|(k, _)| fixed + k);
            let kept: Vec<usize> = (0..fixed).chain(own).collect();
            let less = left(&kept)?;
            let lost: Vec<f64> = less.iter().zip(&whole).map(|(a, b)| a - b).collect();
            // Relative to each block, so that one with most of the error does not decide alone.
            let relative: Vec<f64> =
                lost.iter().zip(&less).map(|(l, s)| l / s.max(f64::MIN_POSITIVE)).collect();
            let p = |values: &[f64]| match paired_t_test(values) {
                Some(t) if t.mean_difference > 0.0 => 0.5 * t.p,
                _ => 1.0,
            };
            let half = mean_half_width_95(&lost).unwrap_or(f64::INFINITY);
            let ratio = |lost: f64| (1.0 + lost / size).max(0.0).sqrt();
            Some(Dependence {
                on: (*group).to_owned(),
                error_ratio: ratio(mean(&lost)),
                ci95: [ratio(mean(&lost) - half), ratio(mean(&lost) + half)],
                p_value: (2.0 * p(&lost).min(p(&relative))).min(1.0),
            })
        })
        .collect();
    all.sort_by(|a, b| b.error_ratio.total_cmp(&a.error_ratio));
    all
}
