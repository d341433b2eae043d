use pam_report::figure::MapPoint;
use pam_report::{ColourMap, ValuePlane};

fn map(ringed: impl Fn(usize) -> bool) -> ColourMap {
    let point = |k: usize| {
        let (x, y) = (100.0 + 35.0 * (k % 15) as f64, 100.0 + 35.0 * (k / 15) as f64);
        MapPoint { x, y, value: k as f64 / 225.0, ringed: ringed(k) }
    };
    ColourMap {
        plane: ValuePlane {
            title: "Map".into(),
            x_label: "x".into(),
            y_label: "y".into(),
            value_label: "value".into(),
            limits: (0.0, 1.0),
            size: (520, 400),
        },
        points: (0..225).map(point).collect(),
        ring_label: "trained on".into(),
    }
}

/// A number after `name` in a text.
fn number(text: &str, name: &str) -> f64 {
    let rest = text.split(name).nth(1).unwrap();
    rest.split([' ', '"', '>']).next().unwrap().parse().unwrap()
}

/// Places (px) and radii of the ringed points.
fn rings(svg: &str) -> Vec<[f64; 3]> {
    let plot = svg.split("class=\"data\"").nth(1).unwrap();
    let scale = [number(plot, " width=\""), number(plot, " height=\"")].map(|px| px / 20_000.0);
    let marks = plot.split("data-at=\"").skip(1).filter(|mark| mark.contains("<circle"));
    marks
        .map(|mark| {
            let at: Vec<f64> =
                mark.split('"').next().unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
            [at[0] * scale[0], at[1] * scale[1], number(mark, " r=\"")]
        })
        .collect()
}

#[test]
fn rings_stand_around_their_points_only() {
    let svg = map(|k| k % 16 == 0).to_svg();
    let rings = rings(&svg);
    assert_eq!(rings.len(), 15, "the diagonal");
    assert!(svg.contains("trained on"));
    for pair in rings.windows(2) {
        assert!(pair[1][0] > pair[0][0] && pair[1][1] < pair[0][1], "up the diagonal");
        let distance = (pair[1][0] - pair[0][0]).max(pair[0][1] - pair[1][1]);
        assert!(pair[0][2] <= 0.5 * distance + 1.0, "neighbours do not touch");
    }
}

#[test]
fn without_rings_there_is_no_legend() {
    let svg = map(|_| false).to_svg();
    assert!(rings(&svg).is_empty() && !svg.contains("trained on"));
}

/// A linear model has one stiffness: the ends of the scale are the same.
#[test]
fn a_constant_map_is_drawn() {
    for limits in [(150.0, 150.0), (0.0, 0.0), (f64::NAN, 1.0), (-1e308, 1e308), (1e300, 1e300)] {
        let mut constant = map(|_| false);
        constant.plane.limits = limits;
        constant.points.iter_mut().for_each(|p| p.value = limits.0);
        assert!(constant.to_svg().contains("</svg>"), "{limits:?}");
    }
}
