//! Air masses for a motion and a stiffness: the global optimum, with a certificate.
//!
//! At a fixed displacement and velocity the force is piecewise affine in the two masses. The masses that
//! give a wanted force form a curve of straight segments, one in each polygon that it crosses. Along a
//! segment the stiffness estimate
//!
//! ```text
//! K̂ = [f(x + 2h) + f(x + h) − f(x − h) − f(x − 2h)] / (6h)
//! ```
//!
//! is piecewise affine too: it bends where one of its four forces does. Least and nearest values are at
//! the bends or where K̂ passes the wanted one, so a finite list of numbers holds the optimum.
//!
//! **Certificate.** The polygons of the masses are found from neighbour to neighbour, and their areas are
//! summed. If they fill the window, no piece of the curve was left out, and the optimum is global to
//! rounding: no branch of the curve, closed loops included, can hide.

use crate::atlas::{Atlas, AtlasMemory, NONE};
use crate::cell::Window;
use crate::network::{LANES, PiecewiseNetwork, Plane};
use crate::partition::{Partition, Partitioner};

/// What is wanted at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InverseProblem {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// The restoring force f that the motion needs, mN: `F_e − m ẍ − B ẋ`.
    pub force_mn: f64,
    /// Wanted stiffness, mN/mm.
    pub stiffness_mn_mm: f64,
    /// Step h of the stiffness estimate, mm.
    pub step_mm: f64,
    /// Bounds of m_f and m_e, g.
    pub bounds: Window,
}

/// What proves that a solution is the global optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// Polygons of the masses in which the force is affine.
    pub polygons: usize,
    /// The part of the window that they leave uncovered, of either sign; zero to rounding.
    pub missing: f64,
    /// Straight segments of the curve of consistent masses.
    pub segments: usize,
    /// Pieces of those on which K̂ is affine.
    pub pieces: usize,
}

impl Certificate {
    /// Whether the polygons fill the window, up to a part of 1e-9.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.missing.abs() < 1e-9
    }
}

/// The optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InverseSolution {
    /// m_f and m_e, g.
    pub masses_g: [f64; 2],
    /// K̂ there, mN/mm.
    pub stiffness_mn_mm: f64,
    /// The force there less the wanted one, mN: zero to rounding unless the motion is out of reach.
    pub residual_mn: f64,
    /// Least and largest K̂ of all consistent masses, mN/mm; none if the motion is out of reach.
    pub reachable_mn_mm: Option<[f64; 2]>,
    /// The proof.
    pub certificate: Certificate,
}

/// Offsets of the stiffness estimate in steps, with their weights in sixths of 1/h.
const STENCIL: [(f64, f64); 4] = [(2.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (-2.0, -1.0)];
/// Most polygons that are looked for.
const MOST_POLYGONS: usize = 1_000_000;
/// Most sign changes along one segment.
const MOST_CROSSINGS: usize = 100_000;

/// Solves one instant after the other in the same memory.
#[derive(Debug, Default)]
pub struct InverseSolver {
    partitioner: Partitioner,
    stencil: [AtlasMemory; 4],
    walks: [Vec<(f64, f64)>; 4],
    bends: Vec<f64>,
}

/// The best point so far.
struct Best {
    masses_g: [f64; 2],
    stiffness: f64,
    miss: f64,
    away: f64,
}

impl InverseSolver {
    /// The global optimum of `(K̂ − K_d)²` over all masses within the bounds that give the force; of
    /// several that reach K_d, the one nearest to `hint`. If none give the force, the masses that miss it
    /// by least.
    ///
    /// A polygon on which the force is constant and equal to the wanted one, which takes a network that
    /// ignores both masses there, counts by its corners only.
    pub fn solve(
        &mut self,
        network: &PiecewiseNetwork,
        problem: &InverseProblem,
        hint: [f64; 2],
    ) -> InverseSolution {
        let at = |offset: f64| {
            let x = problem.displacement_mm + offset * problem.step_mm;
            Plane::of_masses(x, problem.velocity_mm_s)
        };
        let bounds = problem.bounds;
        let partition = self.partitioner.partition(network, at(0.0), bounds, MOST_POLYGONS);
        let memories = std::mem::take(&mut self.stencil);
        let mut k = 0;
        let mut atlases = memories.map(|memory| {
            k += 1;
            Atlas::new(network, at(STENCIL[k - 1].0), bounds, memory)
        });
        let mut best: Option<Best> = None;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut segments, mut pieces) = (0, 0);
        for polygon in &partition.polygons {
            let Some([from, to]) =
                level_segment(&polygon.corners, &polygon.force, problem.force_mn)
            else {
                continue;
            };
            segments += 1;
            self.bends.clear();
            for (atlas, walk) in atlases.iter_mut().zip(&mut self.walks) {
                walk_line(atlas, from, to, walk);
                self.bends.extend(walk.iter().map(|w| w.0));
            }
            self.bends.sort_by(f64::total_cmp);
            self.bends.dedup();
            let walks = &self.walks;
            let stiffness = |t: f64| {
                let sum: f64 = STENCIL.iter().zip(walks).map(|(s, w)| s.1 * read(w, t)).sum();
                sum / (6.0 * problem.step_mm)
            };
            let mut offer = |t: f64, stiffness: f64| {
                let masses_g = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
                let miss = (stiffness - problem.stiffness_mn_mm).abs();
                let away = (masses_g[0] - hint[0]).hypot(masses_g[1] - hint[1]);
                let better = best
                    .as_ref()
                    .is_none_or(|b| miss < b.miss || (miss == b.miss && away < b.away));
                if better {
                    best = Some(Best { masses_g, stiffness, miss, away });
                }
            };
            let mut before: Option<(f64, f64)> = None;
            for &t in &self.bends {
                let here = stiffness(t);
                range = [range[0].min(here), range[1].max(here)];
                offer(t, here);
                if let Some((start, there)) = before {
                    pieces += 1;
                    let share = (problem.stiffness_mn_mm - there) / (here - there);
                    if share > 0.0 && share < 1.0 {
                        offer(start + share * (t - start), problem.stiffness_mn_mm);
                    }
                }
                before = Some((t, here));
            }
        }
        let certificate = Certificate {
            polygons: partition.polygons.len(),
            missing: partition.missing,
            segments,
            pieces,
        };
        let solution = match best {
            Some(best) => InverseSolution {
                masses_g: best.masses_g,
                stiffness_mn_mm: best.stiffness,
                residual_mn: residual(network, problem, best.masses_g),
                reachable_mn_mm: Some(range),
                certificate,
            },
            None => nearest_force(&mut atlases, &partition, problem, certificate),
        };
        self.stencil = atlases.map(Atlas::into_memory);
        solution
    }
}

/// The force at two masses less the wanted one.
fn residual(network: &PiecewiseNetwork, problem: &InverseProblem, masses_g: [f64; 2]) -> f64 {
    let [m_f, m_e] = masses_g;
    network.force_mn([m_f, m_e, problem.displacement_mm, problem.velocity_mm_s]) - problem.force_mn
}

/// The corner that comes nearest to the wanted force.
fn nearest_force(
    atlases: &mut [Atlas<'_>; 4],
    partition: &Partition,
    problem: &InverseProblem,
    certificate: Certificate,
) -> InverseSolution {
    let mut best = ([problem.bounds.first[0], problem.bounds.second[0]], f64::INFINITY);
    for polygon in &partition.polygons {
        for &corner in &polygon.corners {
            let miss = polygon.force_mn(corner) - problem.force_mn;
            if miss.abs() < best.1.abs() {
                best = (corner, miss);
            }
        }
    }
    let sum: f64 = STENCIL
        .iter()
        .zip(atlases)
        .map(|(s, atlas)| {
            let id = atlas.at(best.0);
            let [a, b, c] = atlas.pattern(id).force;
            s.1 * (a + b * best.0[0] + c * best.0[1])
        })
        .sum();
    InverseSolution {
        masses_g: best.0,
        stiffness_mn_mm: sum / (6.0 * problem.step_mm),
        residual_mn: best.1,
        reachable_mn_mm: None,
        certificate,
    }
}

/// Where the line `force = wanted` runs through a convex polygon.
fn level_segment(corners: &[[f64; 2]], force: &[f64; 3], wanted: f64) -> Option<[[f64; 2]; 2]> {
    let g = |v: [f64; 2]| force[0] + force[1] * v[0] + force[2] * v[1] - wanted;
    let mut ends: [Option<[f64; 2]>; 2] = [None; 2];
    for k in 0..corners.len() {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        let (ga, gb) = (g(a), g(b));
        if (ga >= 0.0) == (gb >= 0.0) {
            continue;
        }
        let t = ga / (ga - gb);
        let at = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        ends[usize::from(ga < 0.0)] = Some(at);
    }
    Some([ends[0]?, ends[1]?])
}

/// The force of an atlas along a segment: parameters `t` in `[0, 1]` of its bends and ends, with the
/// values there.
fn walk_line(atlas: &mut Atlas<'_>, from: [f64; 2], to: [f64; 2], out: &mut Vec<(f64, f64)>) {
    let along = [to[0] - from[0], to[1] - from[1]];
    let mut id = atlas.at(from);
    let mut t = 0.0;
    out.clear();
    for _ in 0..MOST_CROSSINGS {
        let pattern = *atlas.pattern(id);
        let mut exit = (1.0, 0, LANES);
        for (block, sides) in atlas.sides(pattern.sides, pattern.side_blocks).iter().enumerate() {
            for lane in (0..LANES).filter(|&l| sides.unit[l] != NONE) {
                let slope = sides.beta[lane] * along[0] + sides.gamma[lane] * along[1];
                if slope < 0.0 {
                    let leaves = (-sides.half_plane(lane).margin(from) / slope).max(t);
                    if leaves < exit.0 {
                        exit = (leaves, block, lane);
                    }
                }
            }
        }
        let [a, b, c] = pattern.force;
        let value = |t: f64| a + b * (from[0] + t * along[0]) + c * (from[1] + t * along[1]);
        if exit.0 > t || out.is_empty() {
            out.push((t, value(t)));
        }
        t = exit.0;
        if exit.2 == LANES {
            out.push((1.0, value(1.0)));
            return;
        }
        let entry = [from[0] + t * along[0], from[1] + t * along[1]];
        id = atlas.behind(id, exit.1, exit.2, Some(entry));
    }
}

/// A piecewise linear function at `t`.
fn read(points: &[(f64, f64)], t: f64) -> f64 {
    let k = points.partition_point(|p| p.0 <= t).clamp(1, points.len() - 1);
    let ((t0, f0), (t1, f1)) = (points[k - 1], points[k]);
    if t1 == t0 { f0 } else { f0 + (f1 - f0) * ((t - t0) / (t1 - t0)) }
}
