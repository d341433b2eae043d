use crate::regions::cache::RegionCache;
use crate::regions::facets::FacetIndex;

/// A straight segment of the plane, `t` from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneSegment {
    from: [f64; 2],
    to: [f64; 2],
}

/// A knot of a piecewise linear function.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knot {
    pub(super) t: f64,
    force_mn: f64,
}

/// Largest number of facets that a segment may cross.
const MAX_CROSSINGS: usize = 100_000;

impl PlaneSegment {
    /// The part of the line `a + b p + c r = level` inside a convex polygon.
    pub(super) fn level_set(vertices: &[[f64; 2]], force: &[f64; 3], level: f64) -> Option<Self> {
        let g = |v: [f64; 2]| force[0] + force[1] * v[0] + force[2] * v[1] - level;
        let mut ends: [Option<[f64; 2]>; 2] = [None; 2];
        for k in 0..vertices.len() {
            let (a, b) = (vertices[k], vertices[(k + 1) % vertices.len()]);
            let (ga, gb) = (g(a), g(b));
            if (ga >= 0.0) == (gb >= 0.0) {
                continue;
            }
            ends[usize::from(ga < 0.0)] = Some(Self { from: a, to: b }.at(ga / (ga - gb)));
        }
        Some(Self { from: ends[0]?, to: ends[1]? })
    }

    fn direction(&self) -> [f64; 2] {
        [self.to[0] - self.from[0], self.to[1] - self.from[1]]
    }

    pub(super) fn at(&self, t: f64) -> [f64; 2] {
        let along = self.direction();
        [self.from[0] + t * along[0], self.from[1] + t * along[1]]
    }

    /// Writes the knots of the force along the segment: its ends and the crossings of facets.
    pub(super) fn force_along(&self, cache: &mut RegionCache<'_>, out: &mut Vec<Knot>) {
        let mut id = cache.locate(self.from);
        let mut t = 0.0;
        out.clear();
        for _ in 0..MAX_CROSSINGS {
            let (end, facet) = self.exit(cache, id, t);
            let [a, b, c] = cache.region(id).force;
            let knot = |t: f64| {
                let [p, r] = self.at(t);
                Knot { t, force_mn: a + b * p + c * r }
            };
            if end > t || out.is_empty() {
                out.push(knot(t));
            }
            t = end;
            let Some(facet) = facet else {
                out.push(knot(1.0));
                return;
            };
            id = cache.neighbour(id, facet, Some(self.at(t)));
        }
    }

    /// Where the segment leaves a region after `t`, and through which facet; its end if it does not.
    fn exit(&self, cache: &RegionCache<'_>, id: u32, t: f64) -> (f64, Option<FacetIndex>) {
        let along = self.direction();
        let mut exit = (1.0, None);
        for (block, facets) in cache.facets(cache.region(id).facets).iter().enumerate() {
            for lane in facets.lanes() {
                let slope = facets.beta[lane] * along[0] + facets.gamma[lane] * along[1];
                if slope < 0.0 {
                    let leaves = (-facets.half_plane(lane).margin(self.from) / slope).max(t);
                    if leaves < exit.0 {
                        exit = (leaves, Some(FacetIndex { block, lane }));
                    }
                }
            }
        }
        exit
    }
}

/// The force at `t` by linear interpolation between knots.
pub(super) fn interpolate(knots: &[Knot], t: f64) -> f64 {
    let k = knots.partition_point(|p| p.t <= t).clamp(1, knots.len() - 1);
    let [Knot { t: t0, force_mn: f0 }, Knot { t: t1, force_mn: f1 }] = [knots[k - 1], knots[k]];
    if t1 == t0 { f0 } else { f0 + (f1 - f0) * ((t - t0) / (t1 - t0)) }
}
