use pam_report::{Band, LineFigure, Role, Scale, Stroke};

#[test]
fn a_figure_names_its_axes_and_survives_odd_data() {
    let nan = vec![(0.0, f64::NAN), (1.0, 2.0)];
    let figure = LineFigure::new("Title", "time (s)", "force (N)", 300, 200)
        .with("measured", Role::Measured, nan)
        .with("", Role::Residual, vec![]);
    let svg = figure.to_svg();
    for part in ["width=\"300\" height=\"200\"", "viewBox=\"0 0 300 200\"", "time (s)", "measured"]
    {
        assert!(svg.contains(part), "{part}");
    }
    let empty = LineFigure::new("", "", "", 300, 200).to_svg();
    assert!(empty.ends_with("</svg>\n"));
}

#[test]
fn bands_verticals_and_lone_points_are_drawn() {
    let band = |from, to, label: &str| Band { from, to, label: label.into() };
    let figure = LineFigure::new("", "x", "y", 300, 200)
        .with_stroke("", Role::Residual, Stroke::Dashed, vec![(0.0, 0.0), (10.0, 1.0)])
        .with("", Role::Category(2), vec![(5.0, 0.5)])
        .with_bands(vec![band(0.0, 5.0, "one"), band(5.0, 9.9, "two"), band(9.9, 10.0, "six")])
        .with_vertical(2.0, Role::Category(5))
        .with_vertical(99.0, Role::Category(1));
    let svg = figure.to_svg();
    assert_eq!(svg.matches("<circle").count(), 1);
    assert_eq!(svg.matches("<rect").count(), 2, "ground of the figure and of every other band");
    let label = |name: &str| svg.split("class=\"band-label\"").find(|text| text.contains(name));
    assert!(label(">two<").unwrap().contains("\"visible\""));
    assert!(label(">six<").unwrap().contains("\"hidden\""), "too narrow");
    assert_eq!(svg.matches("stroke-dasharray=\"6 4\"").count(), 1, "dashes");
    assert_eq!(svg.matches("stroke-dasharray=\"1.5 3\"").count(), 1, "one vertical line");
    assert!(
        svg.contains("#d55e00") && !svg.contains("#e69f00"),
        "the other one is outside the axis"
    );
}

#[test]
fn logarithmic_axes_leave_out_what_they_cannot_show_and_legends_take_rows() {
    let mut figure = LineFigure::new("Errors", "time (s)", "error", 300, 200)
        .with_scales(Scale::Logarithmic, Scale::Logarithmic)
        .with_marks();
    for k in 0..5 {
        let points = vec![(1e-3, 1e-9), (1.0, 0.0), (10.0, 1e-2)];
        figure = figure.with(&format!("method number {k}"), Role::Category(k), points);
    }
    let svg = figure.to_svg();
    assert_eq!(svg.matches("<circle").count(), 2 * 5, "zero has no place");
    for part in ["10⁻⁸", "0.01", "method number 4"] {
        assert!(svg.contains(part), "{part}");
    }
}
