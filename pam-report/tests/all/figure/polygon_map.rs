use pam_report::ValuePlane;
use pam_report::figure::{PolygonMap, ValuedPolygon};

#[test]
fn every_polygon_is_drawn_in_the_colour_of_its_value() {
    let square = |x: f64, value: f64| ValuedPolygon {
        corners: vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]],
        value,
    };
    let svg = PolygonMap {
        plane: ValuePlane {
            title: "Map".into(),
            x_label: "x".into(),
            y_label: "v".into(),
            value_label: "K".into(),
            limits: (10.0, 20.0),
            size: (520, 400),
        },
        polygons: vec![square(0.0, 10.0), square(1.0, 20.0), square(2.0, 99.0)],
        window: [[0.0, 3.0], [0.0, 1.0]],
    }
    .to_svg();
    let fills: Vec<&str> = svg
        .split("<polygon")
        .skip(1)
        .map(|p| p.split("fill=\"").nth(1).and_then(|f| f.split('"').next()).unwrap())
        .collect();
    assert_eq!(fills.len(), 3);
    assert_ne!(fills[0], fills[1]);
    assert_eq!(fills[1], fills[2], "beyond the scale its end counts");
}
