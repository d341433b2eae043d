//! Time and state at which a step leaves its region.

use super::closed_form::Step;
use super::event::EventFunction;
use super::monotonic_exit::{FacetCrossing, Outlook};
use super::propagator::LONGEST;
use super::taylor::TaylorSeries;
use crate::regions::facets::{FacetBlock, FacetIndex};
use crate::simd::LANES;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// The crossing of a facet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RegionExit {
    pub(crate) after_s: f64,
    pub(crate) state: [f64; 2],
    pub(crate) facet: FacetIndex,
    /// The unit that changes its sign.
    pub(crate) unit: u32,
}

impl RegionExit {
    /// The first facet that the motion crosses in a step. `entered` is the unit whose facet was crossed just
    /// before. With `slides`, facets on which the step starts are ignored.
    #[inline(always)]
    pub(crate) fn first<S: Simd>(
        simd: S,
        facets: &[FacetBlock],
        step: &Step,
        entered: u32,
        slides: bool,
    ) -> Option<Self> {
        if let ([facets], false) = (facets, slides) {
            match step.outlook(simd, facets, entered) {
                Outlook::Stays => return None,
                Outlook::Leaves(FacetCrossing { after_s, state, lane }) => {
                    let facet = FacetIndex { block: 0, lane };
                    return Some(Self { after_s, state, facet, unit: facets.unit[lane] });
                }
                Outlook::Undecided => {}
            }
        }
        // A copy: the original can stay in registers.
        let step = *step;
        examine_each(EachFacet { facets, step: &step, entered, slides })
    }
}

/// Facets that are examined one by one.
struct EachFacet<'a> {
    facets: &'a [FacetBlock],
    step: &'a Step,
    entered: u32,
    slides: bool,
}

#[cold]
#[inline(never)]
fn examine_each(job: EachFacet<'_>) -> Option<RegionExit> {
    arch().dispatch(job)
}

impl WithSimd for EachFacet<'_> {
    type Output = Option<RegionExit>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<RegionExit> {
        let Self { facets, step, entered, slides } = self;
        let deviation = step.chord_deviation();
        let series = TaylorSeries::<LONGEST>::new(step);
        let mut found: Option<RegionExit> = None;
        for (block, facets) in facets.iter().enumerate() {
            let before = facets.margins(step.from);
            let after = facets.margins(step.end);
            for lane in 0..LANES {
                let line = [facets.alpha[lane], facets.beta[lane], facets.gamma[lane]];
                let far = line[1].abs().mul_add(deviation[0], line[2].abs() * deviation[1]);
                if before[lane].min(after[lane]) > far {
                    continue;
                }
                let mut margin = EventFunction::new(line, &series, step.magnitudes());
                // The tables of two regions agree on their common facet to rounding only.
                if facets.unit[lane] == entered {
                    margin.start_at_zero();
                }
                if slides && before[lane] <= 64.0 * margin.noise() {
                    continue;
                }
                let limit = found.as_ref().map_or(step.h, |f| f.after_s);
                let Some(after_s) = margin.first_exit(limit) else { continue };
                if after_s < limit || found.is_none() {
                    let (state, unit) = (series.at(after_s), facets.unit[lane]);
                    let facet = FacetIndex { block, lane };
                    found = Some(RegionExit { after_s, state, facet, unit });
                    if after_s == 0.0 {
                        return found;
                    }
                }
            }
        }
        found
    }
}
