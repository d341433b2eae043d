use super::along_segment::{Knot, PlaneSegment, interpolate};
use super::problem::{Certificate, InverseProblem, InverseSolution};
use crate::network::{Plane, ReluNetwork};
use crate::regions::Partition;
use crate::regions::cache::{RegionCache, RegionWorkspace};

/// Offsets of the stiffness estimate in steps h, with their weights in units of 1/(6h).
const STENCIL: [(f64, f64); 4] = [(2.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (-2.0, -1.0)];
/// Largest number of regions.
const MAX_REGIONS: usize = 1_000_000;

/// Solves one instant after the other in the same memory.
#[derive(Debug, Default)]
pub struct InverseSolver {
    regions: RegionWorkspace,
    stencil: [RegionWorkspace; 4],
    /// Along the current segment, the forces of the stencil.
    forces: [Vec<Knot>; 4],
    /// Places where K̂ bends, and the ends.
    bends: Vec<f64>,
}

/// Masses and their stiffness, with the distances from the wanted stiffness and from the hint.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    masses_g: [f64; 2],
    stiffness: f64,
    miss: f64,
    from_hint: f64,
}

/// The search over all segments of the curve of consistent masses.
struct Search<'a> {
    problem: &'a InverseProblem,
    hint: [f64; 2],
    best: Option<Candidate>,
    reachable: [f64; 2],
    certificate: Certificate,
}

impl InverseSolver {
    /// The global optimum of `(K̂ − K_d)²` over all masses within the bounds that give the force; of
    /// several that reach K_d, the one nearest to `hint`. If none gives the force, the masses that miss it
    /// by least.
    ///
    /// A region on which the force is constant and equal to the wanted one, which takes a network that
    /// ignores both masses there, counts by its vertices only.
    pub fn solve(
        &mut self,
        network: &ReluNetwork,
        problem: &InverseProblem,
        hint: [f64; 2],
    ) -> InverseSolution {
        let plane = |offset: f64| {
            let x = problem.displacement_mm + offset * problem.step_mm;
            Plane::of_masses(x, problem.velocity_mm_s)
        };
        let bounds = problem.bounds;
        let partition =
            Partition::in_workspace(network, plane(0.0), bounds, MAX_REGIONS, &mut self.regions);
        let mut offsets = STENCIL.iter();
        let mut caches = std::mem::take(&mut self.stencil).map(|workspace| {
            let offset = offsets.next().map_or(0.0, |s| s.0);
            RegionCache::new(network, plane(offset), bounds, workspace)
        });
        let mut search = Search {
            problem,
            hint,
            best: None,
            reachable: [f64::INFINITY, f64::NEG_INFINITY],
            certificate: Certificate {
                regions: partition.regions.len(),
                uncovered_share: partition.uncovered_share,
                segments: 0,
                pieces: 0,
            },
        };
        for region in &partition.regions {
            let level = problem.force_mn;
            if let Some(segment) = PlaneSegment::level_set(&region.vertices, &region.force, level) {
                self.tabulate(&segment, &mut caches);
                search.add_segment(&segment, &self.bends, &self.forces);
            }
        }
        let solution = match search.best {
            Some(best) => search.solution(network, &best),
            None => nearest_force(&mut caches, &partition, problem, search.certificate),
        };
        self.stencil = caches.map(RegionCache::into_workspace);
        solution
    }

    /// Tabulates the forces of the stencil along a segment, and where any of them bends.
    fn tabulate(&mut self, segment: &PlaneSegment, caches: &mut [RegionCache<'_>; 4]) {
        self.bends.clear();
        for (cache, knots) in caches.iter_mut().zip(&mut self.forces) {
            segment.force_along(cache, knots);
            self.bends.extend(knots.iter().map(|knot| knot.t));
        }
        self.bends.sort_by(f64::total_cmp);
        self.bends.dedup();
    }
}

/// K̂ from the four forces of the stencil.
fn stiffness(forces: impl Iterator<Item = f64>, step_mm: f64) -> f64 {
    let sum: f64 = STENCIL.iter().zip(forces).map(|(s, force)| s.1 * force).sum();
    sum / (6.0 * step_mm)
}

impl Search<'_> {
    /// Examines the bends of K̂ along a segment, and where it equals the wanted one in between.
    fn add_segment(&mut self, segment: &PlaneSegment, bends: &[f64], forces: &[Vec<Knot>; 4]) {
        self.certificate.segments += 1;
        let wanted = self.problem.stiffness_mn_mm;
        let mut before: Option<(f64, f64)> = None;
        for &t in bends {
            let forces = forces.iter().map(|knots| interpolate(knots, t));
            let here = stiffness(forces, self.problem.step_mm);
            self.reachable = [self.reachable[0].min(here), self.reachable[1].max(here)];
            self.offer(segment.at(t), here);
            if let Some((start, there)) = before {
                self.certificate.pieces += 1;
                let share = (wanted - there) / (here - there);
                if share > 0.0 && share < 1.0 {
                    self.offer(segment.at(start + share * (t - start)), wanted);
                }
            }
            before = Some((t, here));
        }
    }

    fn offer(&mut self, masses_g: [f64; 2], stiffness: f64) {
        let miss = (stiffness - self.problem.stiffness_mn_mm).abs();
        let from_hint = (masses_g[0] - self.hint[0]).hypot(masses_g[1] - self.hint[1]);
        let better =
            self.best.is_none_or(|b| miss < b.miss || (miss == b.miss && from_hint < b.from_hint));
        if better {
            self.best = Some(Candidate { masses_g, stiffness, miss, from_hint });
        }
    }

    fn solution(&self, network: &ReluNetwork, best: &Candidate) -> InverseSolution {
        let InverseProblem { displacement_mm, velocity_mm_s, force_mn, .. } = *self.problem;
        let [m_f, m_e] = best.masses_g;
        InverseSolution {
            masses_g: best.masses_g,
            stiffness_mn_mm: best.stiffness,
            residual_mn: network.force_mn([m_f, m_e, displacement_mm, velocity_mm_s]) - force_mn,
            reachable_mn_mm: Some(self.reachable),
            certificate: self.certificate,
        }
    }
}

/// The vertex of a region that comes nearest to the wanted force.
fn nearest_force(
    caches: &mut [RegionCache<'_>; 4],
    partition: &Partition,
    problem: &InverseProblem,
    certificate: Certificate,
) -> InverseSolution {
    let mut masses_g = [problem.bounds.first[0], problem.bounds.second[0]];
    let mut residual_mn = f64::INFINITY;
    for region in &partition.regions {
        for &vertex in &region.vertices {
            let residual = region.force_mn(vertex) - problem.force_mn;
            if residual.abs() < residual_mn.abs() {
                (masses_g, residual_mn) = (vertex, residual);
            }
        }
    }
    let forces = caches.iter_mut().map(|cache| {
        let id = cache.locate(masses_g);
        let [a, b, c] = cache.region(id).force;
        a + b * masses_g[0] + c * masses_g[1]
    });
    InverseSolution {
        masses_g,
        stiffness_mn_mm: stiffness(forces, problem.step_mm),
        residual_mn,
        reachable_mn_mm: None,
        certificate,
    }
}
