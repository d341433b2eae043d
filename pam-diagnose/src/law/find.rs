//! From a correction to a law.

use super::design::Design;
use super::library::library;
use super::refine::{Proposal, Tried, preferred, refine};
use super::select::Scores;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Problem};
use crate::noise::Noise;
use crate::remainder::{Dyn, Ground, Learned};
use crate::terms::{Definition, Function, Term, TermSpace};
use std::time::Instant;

/// Terms of a block of the library.
const BLOCK: usize = 8;

fn show(term: &Term, c: f64, names: &[String]) -> String {
    let parts: Vec<String> = term.factors.iter().map(|f| {
        let lag = f.lag.map_or(String::new(), |l| format!("lag{:?}({})", l.of, l.time_s));
        let scale = if f.function.has_scale() { format!("[{:.3}]", f.scale) } else { String::new() };
        format!("{:?}{scale}({lag} {})", f.function, names[f.variable])
    }).collect();
    format!("{:.4}@{} {}", c * term.coefficient, term.place, parts.join("*"))
}

pub(crate) fn find<T: TermSpace>(
    space: &T,
    ground: &Ground<'_>,
    learned: &Learned,
) -> Result<(), DiagnoseError> {
    let names: Vec<String> = space.variables().iter().map(|v| v.text.clone()).collect();
    let families: Vec<usize> =
        learned.terms.iter().map(|t| space.places()[t[0].place].family).collect();
    let terms = library(&families, space.variables(), space.places());
    eprintln!("library {} terms", terms.len());
    let clock = Instant::now();
    let corrections = learned.definitions(space);
    let mut definitions = corrections.clone();
    definitions.extend(blocks_of(space, &terms));
    let first = ground.listed + corrections.len();
    let (noise, rpo, chi, sets) = space.with(&definitions, |system| {
        let mut rows = ground.rows(system, &learned.fit.hypothesis).ok_or_else(|| {
            DiagnoseError::TooLittle("the correction diverges".into())
        })?;
        let start = Hypothesis { locals: rows.whole.base().locals, ..learned.fit.hypothesis.clone() };
        let fit = rows.whole.fit_to(start, 2, 1.0)?;
        let noise = Noise::learned(&rows.whole, &fit.hypothesis, &ground.prior)
            .ok_or_else(|| DiagnoseError::TooLittle("the correction diverges".into()))?;
        rows.set_noise(&noise, &fit.hypothesis);
        let fit = rows.whole.fit_to(fit.hypothesis, 2, 1.0)?;
        let rpo = rows.whole.correlated_rows(&fit.hypothesis)?;
        eprintln!("  whole fit {:.2} s chi {:.3?} rpo {rpo:.2} noise {:.4?}", clock.elapsed().as_secs_f64(), fit.errors.mean(), noise.deviations());
        let all = swept(space, &rows.whole, &fit.hypothesis, &terms, first, rpo, &names)?;
        eprintln!("  swept {:.2} s", clock.elapsed().as_secs_f64());
        Ok((noise, rpo, fit.errors.mean(), all))
    })?;
    let ground = Ground { noise, ..ground.clone() };
    let mut proposals: Vec<Proposal> = Vec::new();
    propose(space, &ground, &sets, &mut proposals);
    let mut tried = refine(space, &ground, &proposals, rpo, 8)?;
    let print = |tried: &[Tried]| {
        for t in tried.iter().take(8) {
            eprintln!("   {:.1} len {:.1} chi {:.2?} named {} {}", t.total, t.length, t.chi, t.named.len(),
                t.terms.iter().map(|t| show(t, 1.0, &names)).collect::<Vec<_>>().join("  +  "));
        }
    };
    eprintln!("  refined {} in {:.2} s; correction {:.2?}", proposals.len(), clock.elapsed().as_secs_f64(), chi);
    print(&tried);
    for round in 0..2 {
        let Some(best) = preferred(&tried).cloned() else { break };
        eprintln!("  preferred {:.1} {}", best.total, best.terms.iter().map(|t| show(t, 1.0, &names)).collect::<Vec<_>>().join("  +  "));
        let near = best.chi.iter().zip(&chi).all(|(own, least)| *own < 1.1 * least.max(1.0));
        if near {
            break;
        }
        // Once more, about the law itself.
        let definition = Definition::law("law", "", &best.terms, space.variables(), space.places());
        let mut definitions = vec![definition];
        definitions.extend(blocks_of(space, &terms));
        let sets = space.with(&definitions, |system| {
            let start = Hypothesis { members: best.named.clone(), ..ground.start(system) };
            let mut rows = ground.rows(system, &start).ok_or_else(|| {
                DiagnoseError::TooLittle("the law diverges".into())
            })?;
            rows.set_rows_per_observation(rpo);
            let start = Hypothesis { members: best.named.clone(), ..rows.whole.base() };
            let start = start.with(ground.listed, &best.values);
            let fit = rows.whole.fit_to(start, 3, 1.0)?;
            swept(space, &rows.whole, &fit.hypothesis, &terms, ground.listed + 1, rpo, &names)
        })?;
        let mut more = Vec::new();
        propose(space, &ground, &sets, &mut more);
        more.retain(|p| !proposals.iter().any(|o| like(o, p)));
        let old = tried.first().map_or(f64::INFINITY, |t| t.total);
        tried.extend(refine(space, &ground, &more, rpo, 8)?);
        tried.sort_by(|a, b| a.total.total_cmp(&b.total));
        proposals.extend(more);
        eprintln!("  round {round} {:.2} s", clock.elapsed().as_secs_f64());
        print(&tried);
        if tried.first().is_none_or(|t| t.total > old - 6.0) {
            break;
        }
    }
    if let Some(best) = preferred(&tried) {
        println!("   LAW {:.1} chi {:.2?} (correction {:.2?}) {}   [{:.1} s]", best.total, best.chi, chi, best.terms.iter().map(|t| show(t, 1.0, &names)).collect::<Vec<_>>().join("  +  "), clock.elapsed().as_secs_f64());
    }
    Ok(())
}

fn like(a: &Proposal, b: &Proposal) -> bool {
    let holds = |a: &Proposal, b: &Proposal| {
        a.terms.iter().all(|t| b.terms.iter().any(|u| t.is_like(u) && same_scales(t, u)))
    };
    a.named.len() == b.named.len() && a.terms.len() == b.terms.len() && holds(a, b) && holds(b, a)
}

fn same_scales(a: &Term, b: &Term) -> bool {
    let near = |x: f64, y: f64| (x / y).ln().abs() < 0.7;
    a.factors.iter().zip(&b.factors).all(|(f, g)| {
        (!f.function.has_scale() || near(f.scale, g.scale))
            && f.lag.zip(g.lag).is_none_or(|(l, m)| near(l.time_s, m.time_s))
    })
}

fn blocks_of<T: TermSpace>(space: &T, terms: &[Term]) -> Vec<Definition> {
    let of = |(k, block): (usize, &[Term])| {
        Definition::flexible(&format!("block{k}"), block, f64::INFINITY, space.variables(), space.places())
    };
    terms.chunks(BLOCK).enumerate().map(of).collect()
}

fn swept<T: TermSpace>(
    space: &T,
    problem: &Problem<'_, Dyn<'_>>,
    hypothesis: &Hypothesis,
    terms: &[Term],
    first: usize,
    rpo: f64,
    names: &[String],
) -> Result<Vec<Vec<Term>>, DiagnoseError> {
    let design = Design::at(problem, hypothesis)?;
    let blocks: Vec<&[Term]> = terms.chunks(BLOCK).collect();
    let candidates: Vec<(usize, Vec<f64>)> =
        blocks.iter().enumerate().map(|(k, b)| (first + k, vec![0.0; b.len()])).collect();
    let found = design.columns(problem, hypothesis, &candidates);
    let columns: Vec<Vec<f64>> = found
        .into_iter()
        .zip(&blocks)
        .flat_map(|(own, block)| own.unwrap_or_else(|| vec![vec![0.0; design.target.len()]; block.len()]))
        .collect();
    let prices: Vec<f64> = terms
        .iter()
        .map(|t| 2.0 * t.description_length(space.variables(), space.places()))
        .collect();
    let scores = Scores { design: &design, rows_per_observation: rpo };
    let all = scores.beam(&columns, &prices, &[], 3, 12);
    for s in all.iter().take(4) {
        eprintln!("   linear {:.1} misfit {:.1} chi {:.2?} {}", s.total, s.misfit, s.chi,
            s.columns.iter().zip(&s.coefficients).map(|(k, c)| show(&terms[*k], *c, names)).collect::<Vec<_>>().join("  +  "));
    }
    // The best of each size.
    let mut chosen = Vec::new();
    for size in 1..=3 {
        let own = all.iter().filter(|s| s.columns.len() == size).take([8, 6, 4][size - 1]);
        chosen.extend(own.map(|s| {
            let with = |(k, c): (&usize, &f64)| Term { coefficient: c * terms[*k].coefficient, ..terms[*k].clone() };
            s.columns.iter().zip(&s.coefficients).map(with).collect::<Vec<Term>>()
        }));
    }
    Ok(chosen)
}

fn propose<T: TermSpace>(space: &T, ground: &Ground<'_>, sets: &[Vec<Term>], proposals: &mut Vec<Proposal>) {
    let mut add = |terms: Vec<Term>| {
        let plain = Proposal { terms, named: Vec::new() };
        if !proposals.iter().any(|p| like(p, &plain)) {
            proposals.push(plain.clone());
            if !ground.named.is_empty() && plain.terms.len() < 3 {
                proposals.push(Proposal { named: ground.named.clone(), ..plain });
            }
        }
    };
    for terms in sets {
        add(terms.clone());
        let dry: Vec<Term> = terms.iter().map(|t| dry_variant(space, t)).collect();
        if dry != *terms {
            add(dry);
        }
    }
}

/// The term as a level of dry friction, if it is the smooth picture of one.
fn dry_variant<T: TermSpace>(space: &T, term: &Term) -> Term {
    let Some((dry, velocity)) = space.places()[term.place].dry else { return term.clone() };
    let turned = |f: &crate::terms::Factor| {
        f.function == Function::Saturated && f.variable == velocity && f.lag.is_none()
    };
    let Some(at) = term.factors.iter().position(turned) else { return term.clone() };
    let mut level = Term { place: dry, coefficient: -term.coefficient, ..term.clone() };
    level.factors.remove(at);
    level
}
