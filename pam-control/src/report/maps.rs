use crate::stiffness::{ExactMap, Reachable, StiffnessPoint};
use maud::html;
use pam_exact::RegionPolygon;
use pam_report::figure::{
    ColourMap, LineFigure, MapPoint, PolygonMap, Role, Stroke, ValuePlane, ValuedPolygon,
};
use pam_report::page::{figure, page};

/// Maps of stiffness and damping over the masses at x = 0, profiles along x with every scheme, the
/// reachable range over the position, and, for ReLU networks, the polygons of the plane of motion
/// in which stiffness and damping are constant.
#[must_use]
pub fn stiffness_report(
    map: &[StiffnessPoint],
    profiles: &[(String, Vec<StiffnessPoint>)],
    reachable: &[Reachable],
    polygons: &[ExactMap],
    lead: &str,
    made_by: &str,
) -> String {
    let plane = |v: f64, label: &str, value: fn(&StiffnessPoint) -> f64| {
        let points: Vec<MapPoint> = map
            .iter()
            .filter(|p| p.displacement_mm == 0.0 && p.velocity_mm_s == v)
            .map(|p| MapPoint {
                x: p.mass_flexor_g,
                y: p.mass_extensor_g,
                value: value(p),
                ringed: false,
            })
            .collect();
        let ends = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.value), b.max(p.value)));
        ColourMap {
            plane: ValuePlane {
                title: format!("{label}, x = 0, v = {v} mm/s"),
                x_label: "flexor air (g)".into(),
                y_label: "extensor air (g)".into(),
                value_label: label.into(),
                limits: ends,
                size: (500, 380),
            },
            points,
            ring_label: String::new(),
        }
        .to_svg()
    };
    let mut velocities: Vec<f64> = map.iter().map(|p| p.velocity_mm_s).collect();
    velocities.sort_by(f64::total_cmp);
    velocities.dedup();
    let mut range = LineFigure::new("", "x (mm)", "reachable K̂ (N/mm)", 1040, 320);
    for (k, v) in velocities.iter().enumerate() {
        let end = |i: usize| {
            reachable
                .iter()
                .filter(|r| r.velocity_mm_s == *v)
                .filter_map(|r| r.stiffness_n_mm.map(|s| (r.displacement_mm, s[i])))
                .collect::<Vec<_>>()
        };
        range = range.with(&format!("v = {v} mm/s"), Role::Category(k), end(1)).with(
            "",
            Role::Category(k),
            end(0),
        );
    }
    let schemes = |points: &[StiffnessPoint]| {
        let series = |f: fn(&StiffnessPoint) -> f64| {
            points.iter().map(|p| (p.displacement_mm, f(p))).collect::<Vec<_>>()
        };
        LineFigure::new("", "x (mm)", "stiffness (N/mm)", 1040, 300)
            .with("exact", Role::Measured, series(|p| p.exact_n_mm))
            .with_stroke("forward", Role::Category(3), Stroke::Dotted, series(|p| p.forward_n_mm))
            .with_stroke("central", Role::Category(2), Stroke::Dashed, series(|p| p.central_n_mm))
            .with_stroke(
                "Richardson",
                Role::Category(4),
                Stroke::Dashed,
                series(|p| p.richardson_n_mm),
            )
            .with("four-point, smoothed", Role::Predicted, series(|p| p.four_point_n_mm))
            .to_svg()
    };
    let body = html! {
        h2 { "Reachable stiffness" }
        (figure(range.to_svg(), "Least and largest smoothed stiffness of unaccelerated motion within the mass bounds."))
        h2 { "Exact against smoothed" }
        @for (name, points) in profiles {
            (figure(schemes(points), name))
        }
        @if !polygons.is_empty() {
            h2 { "Over displacement and velocity" }
            p {
                "The network has (leaky) ReLU units: its force is affine in each of these polygons, so that "
                "stiffness and damping are constant there. The polygons are exact and fill the plane."
            }
            div.grid {
                @for map in polygons {
                    (figure(polygon_map(map, "K (N/mm)", |p| 1e-3 * p.force[1]), &caption(map)))
                    (figure(polygon_map(map, "damping (kg/s)", |p| p.force[2] + map.auxiliary_damping_kg_s), ""))
                }
            }
        }
        h2 { "Over the masses" }
        div.grid {
            @for v in &velocities {
                (figure(plane(*v, "K̂ (N/mm)", |p| p.four_point_n_mm), ""))
                (figure(plane(*v, "exact K (N/mm)", |p| p.exact_n_mm), ""))
                (figure(plane(*v, "damping (kg/s)", |p| p.damping_kg_s), ""))
            }
        }
    };
    page("Stiffness and damping", lead, &body, made_by)
}

/// Content of a map of polygons.
fn caption(map: &ExactMap) -> String {
    format!(
        "{} polygons; the part of the plane that is not covered: {:.0e}",
        map.partition.regions.len(),
        map.partition.uncovered_share.abs()
    )
}

/// The polygons of a plane of motion, coloured by a value. The colours end at the values that leave out a
/// hundredth of the area on either side, since a few small polygons are far off.
fn polygon_map(map: &ExactMap, label: &str, value: impl Fn(&RegionPolygon) -> f64) -> String {
    let polygons = &map.partition.regions;
    let mut weighted: Vec<(f64, f64)> = polygons.iter().map(|p| (value(p), p.area)).collect();
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = weighted.iter().map(|w| w.1).sum();
    let at = |part: f64| {
        let mut below = 0.0;
        let first = weighted.iter().find(|w| {
            below += w.1;
            below >= part * whole
        });
        first.map_or(0.0, |w| w.0)
    };
    let (low, high) = (at(0.01), at(0.99));
    let window = map.partition.window;
    PolygonMap {
        plane: ValuePlane {
            title: map.name.clone(),
            x_label: "x (mm)".into(),
            y_label: "velocity (mm/s)".into(),
            value_label: label.into(),
            limits: if high > low { (low, high) } else { (low - 0.5, low + 0.5) },
            size: (500, 380),
        },
        polygons: polygons
            .iter()
            .map(|p| ValuedPolygon { corners: p.vertices.clone(), value: value(p) })
            .collect(),
        window: [window.first, window.second],
    }
    .to_svg()
}
