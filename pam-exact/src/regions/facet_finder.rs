use super::by_clipping::Clipper;
use super::by_hull::HullFinder;
use super::facets::{Borders, Entry, FacetBlock, push_facets};

/// Finds the facets of regions: by the hull of dual points where an inner point of the region is found from
/// the entry, else by clipping.
#[derive(Debug, Default)]
pub(crate) struct FacetFinder {
    hull: HullFinder,
    clipper: Clipper,
}

impl FacetFinder {
    /// Appends the facets of a region.
    pub(crate) fn find(
        &mut self,
        borders: Borders<'_>,
        entry: Option<Entry>,
        out: &mut Vec<FacetBlock>,
    ) {
        let entry = entry.filter(|entry| borders.window.contains(entry.point));
        let Some(vertices) = entry.and_then(|entry| self.hull.find(borders, entry)) else {
            self.clipper.find(borders, out);
            return;
        };
        let units = vertices.iter().filter(|&&u| (u as usize) < borders.table.units());
        push_facets(out, units.map(|&u| (u, borders.half_plane(u as usize))));
    }
}

#[cfg(test)]
mod tests {
    use super::super::facets::NONE;
    use super::super::half_plane::Window;
    use super::super::polygon::ConvexPolygon;
    use super::*;
    use crate::network::preactivations::PreActivations;

    /// Numbers in ±1.
    fn spread() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
        }
    }

    fn units(facets: &[FacetBlock]) -> Vec<u32> {
        let mut units: Vec<u32> =
            facets.iter().flat_map(|s| s.unit).filter(|&u| u != NONE).collect();
        units.sort_unstable();
        units
    }

    /// A table without a first layer.
    fn table_of(deeper: &[f64]) -> PreActivations<'_> {
        const NO_LAYER: &[Vec<f64>; 3] = &[const { Vec::new() }; 3];
        PreActivations { first: NO_LAYER, deeper }
    }

    /// The hull of dual points and clipping find the same facets, from an inner point and through a facet.
    #[test]
    fn hull_and_clipping_agree() {
        let mut next = spread();
        let window = Window { first: [-1e5, 1e5], second: [-1e7, 1e7] };
        for case in 0..300 {
            let count = [8, 64, 192][case % 3];
            let scale = [1.0, 20.0][case % 2];
            let mut table: Vec<f64> = (0..3 * count).map(|_| next()).collect();
            table[count..2 * count].iter_mut().for_each(|b| *b *= scale);
            // Padding.
            for k in 0..3 {
                table[k * count + 5] = 0.0;
            }
            let at = |table: &[f64], u: usize, [p, r]: [f64; 2]| {
                table[u] + table[count + u] * p + table[2 * count + u] * r
            };
            let point = [0.3 * next(), 0.3 * next()];
            let mut pattern = vec![0; count.div_ceil(64)];
            for u in (0..count).filter(|&u| at(&table, u, point) > 0.0) {
                pattern[u / 64] |= 1 << (u % 64);
            }
            let mut finder = FacetFinder::default();
            let mut both = |table: &[f64], pattern: &[u64], entry: Entry| {
                let (mut hull, mut clipped) = (Vec::new(), Vec::new());
                let borders = Borders { window: &window, table: table_of(table), pattern };
                finder.find(borders, Some(entry), &mut hull);
                finder.clipper.find(borders, &mut clipped);
                (hull, clipped)
            };
            let (hull, clipped) = both(&table, &pattern, Entry { point, unit: NONE });
            assert_eq!(units(&hull), units(&clipped), "from inside, case {case}");
            // From a point on a border.
            if case % 7 == 0 {
                let u = units(&hull)[0] as usize;
                table[u] -= at(&table, u, point);
                let (hull, clipped) = both(&table, &pattern, Entry { point, unit: NONE });
                assert_eq!(units(&hull), units(&clipped), "from a border, case {case}");
                continue;
            }
            // Through each facet into the region behind it, at the facet's middle.
            for &unit in units(&hull).iter().take(2) {
                let mut polygon = ConvexPolygon::default();
                polygon.restart(&window);
                for block in &hull {
                    for lane in block.lanes() {
                        polygon.clip(&block.half_plane(lane));
                    }
                }
                let borders =
                    Borders { window: &window, table: table_of(&table), pattern: &pattern };
                let plane = borders.half_plane(unit as usize);
                let on: Vec<_> = (polygon.vertices.iter())
                    .filter(|&&v| plane.margin(v).abs() < 1e-9 * (1.0 + v[0].abs() + v[1].abs()))
                    .collect();
                if on.len() != 2 {
                    continue;
                }
                let point = [0.5 * (on[0][0] + on[1][0]), 0.5 * (on[0][1] + on[1][1])];
                let mut behind = pattern.clone();
                behind[unit as usize / 64] ^= 1 << (unit % 64);
                let (hull, clipped) = both(&table, &behind, Entry { point, unit });
                assert_eq!(units(&hull), units(&clipped), "through {unit}, case {case}");
            }
        }
    }
}
