use super::*;

fn point(x: f64, y: f64, half_width: Option<f64>) -> Point {
    Point { x, y, half_width }
}

fn style(name: &str) -> Style {
    Style {
        name: name.to_owned(),
        color: "#0072b2",
        dash: Dash::Short,
    }
}

/// One panel of 0 to 100 by 0 to 100 with one line.
fn figure(points: Vec<Point>) -> Figure {
    Figure {
        title: "Skills & success".to_owned(),
        notes: vec!["A note of <three> words.".to_owned()],
        x_label: "training episodes".to_owned(),
        columns: vec!["door".to_owned()],
        rows: vec![Row {
            label: "success rate, %".to_owned(),
            y_max: Some(100.0),
            panels: vec![vec![Line { style: 0, points }]],
        }],
        styles: vec![style("cip")],
    }
}

/// What stands in an attribute of the elements of one kind.
fn attributes<'a>(svg: &'a str, element: &str, attribute: &str) -> Vec<&'a str> {
    let (open, name) = (format!("<{element} "), format!("{attribute}=\""));
    svg.lines()
        .filter(|line| line.starts_with(&open))
        .filter_map(|line| line.split_once(&name)?.1.split('"').next())
        .collect()
}

fn places(points: &str) -> Vec<(f64, f64)> {
    let place = |pair: &str| {
        let (x, y) = pair.split_once(',').unwrap();
        (x.parse().unwrap(), y.parse().unwrap())
    };
    points.split(' ').map(place).collect()
}

#[test]
fn lines_and_bands_lie_where_their_numbers_say() {
    let points = vec![point(0.0, 0.0, Some(10.0)), point(100.0, 50.0, Some(20.0))];
    let svg = figure(points).to_svg();
    let lines = attributes(&svg, "polyline", "points");
    let [legend, line] = lines[..] else {
        panic!("{lines:?}")
    };
    assert_eq!(places(legend).len(), 2);
    let line = places(line);
    // The whole width to the right, half the height up.
    assert!(
        (line[1].0 - line[0].0 - PANEL_WIDTH).abs() < 0.11,
        "{line:?}"
    );
    assert!(
        (line[0].1 - line[1].1 - PANEL_HEIGHT / 2.0).abs() < 0.11,
        "{line:?}"
    );
    let bands = attributes(&svg, "polygon", "points");
    let band = places(bands[0]);
    // Up there and back below: four corners, 20 % and 40 % of the height apart.
    assert_eq!(band.len(), 4);
    assert!(
        (band[3].1 - band[0].1 - 0.2 * PANEL_HEIGHT).abs() < 0.11,
        "{band:?}"
    );
    assert!(
        (band[2].1 - band[1].1 - 0.4 * PANEL_HEIGHT).abs() < 0.11,
        "{band:?}"
    );
}

#[test]
fn a_line_without_intervals_has_no_band_and_no_points_no_line() {
    let svg = figure(vec![point(0.0, 1.0, None), point(1.0, 2.0, None)]).to_svg();
    assert!(!svg.contains("<polygon"));
    let svg = figure(Vec::new()).to_svg();
    assert_eq!(
        attributes(&svg, "polyline", "points").len(),
        1,
        "the legend's"
    );
    assert!(!svg.contains("NaN"));
}

#[test]
fn it_says_what_it_shows_and_words_are_escaped() {
    let svg = figure(Vec::new()).to_svg();
    for words in [
        "Skills &amp; success",
        "A note of &lt;three&gt; words.",
        ">training episodes<",
        ">success rate, %<",
        ">door<",
        ">cip<",
        ">100<",
        "stroke-dasharray=\"4 2.5\"",
    ] {
        assert!(svg.contains(words), "{words}:\n{svg}");
    }
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for element in ["text", "g", "style", "clipPath", "title", "desc"] {
        let opened = svg.matches(&format!("<{element}>")).count()
            + svg.matches(&format!("<{element} ")).count();
        assert_eq!(
            opened,
            svg.matches(&format!("</{element}>")).count(),
            "{element}"
        );
    }
}

#[test]
fn an_axis_without_an_end_reaches_what_the_lines_need() {
    let mut figure = figure(vec![point(0.0, 0.0, None), point(10.0, 30.0, Some(7.0))]);
    figure.rows[0].y_max = None;
    let svg = figure.to_svg();
    assert!(svg.contains(">40<") && !svg.contains(">50<"), "{svg}");
}

#[test]
fn long_notes_are_cut_between_words() {
    assert_eq!(
        wrapped("one two three four", 9),
        ["one two", "three", "four"]
    );
    assert_eq!(wrapped("", 9), Vec::<String>::new());
    assert_eq!(wrapped("incomprehensible", 9), ["incomprehensible"]);
}
