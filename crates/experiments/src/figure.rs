//! Small charts side by side, as one SVG picture: lines over a common axis, each with a band around it.
//!
//! Columns share the horizontal axis, and all panels of a row the vertical one. The picture stands alone: no script, no
//! font or style from elsewhere, white below it. Same data, same bytes.
//!
//! Lengths inside are in pixels, from the upper left corner, y down.

mod ticks;

use std::fmt::Write as _;

use crate::report::escape;
use ticks::ticks;

const PANEL_WIDTH: f64 = 220.0;
const PANEL_HEIGHT: f64 = 150.0;
const GAP_X: f64 = 20.0;
const GAP_Y: f64 = 24.0;
/// Left of the panels: tick labels and the label of the axis.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 14.0;
const TITLE_HEIGHT: f64 = 28.0;
const LEGEND_LINE_HEIGHT: f64 = 20.0;
const LEGEND_ENTRY_WIDTH: f64 = 128.0;
const HEAD_HEIGHT: f64 = 22.0;
/// Below the panels: tick labels and the label of the axis.
const AXIS_HEIGHT: f64 = 44.0;
const NOTE_HEIGHT: f64 = 15.0;
/// Width of a letter of the notes, about.
const NOTE_LETTER_WIDTH: f64 = 5.6;

/// A picture of charts.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Above everything.
    pub title: String,
    /// Below everything, each a paragraph.
    pub notes: Vec<String>,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Heads of the columns.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
    /// How lines look; they name theirs by its index.
    pub styles: Vec<Style>,
}

/// A row of panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Label of the vertical axis, with its unit.
    pub label: String,
    /// Where the vertical axis ends; what the lines need if absent. It begins at 0.
    pub y_max: Option<f64>,
    /// For each column, its lines.
    pub panels: Vec<Vec<Line>>,
}

/// A line in a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Index of its style.
    pub style: usize,
    /// Its points, from left to right.
    pub points: Vec<Point>,
}

/// A point of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where.
    pub x: f64,
    /// How much.
    pub y: f64,
    /// Half the height of the band there, if there is one.
    pub half_width: Option<f64>,
}

/// How a line looks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Style {
    /// Its name in the legend.
    pub name: String,
    /// Its colour, as SVG says it.
    pub color: &'static str,
    /// Its dashes.
    pub dash: Dash,
}

/// Dashes of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// None.
    Solid,
    /// `....`
    Dots,
    /// `- - -`
    Short,
    /// `-- --`
    Long,
    /// `---- ----`
    Longest,
    /// `-.-.`
    OneDot,
    /// `-..-`
    TwoDots,
}

impl Dash {
    fn pattern(self) -> &'static str {
        match self {
            Self::Solid => "none",
            Self::Dots => "1.5 2.5",
            Self::Short => "4 2.5",
            Self::Long => "9 3",
            Self::Longest => "18 3",
            Self::OneDot => "7 2.5 1.5 2.5",
            Self::TwoDots => "7 2 1.5 2 1.5 2",
        }
    }
}

/// A panel's place, and what its sides stand for.
#[derive(Debug, Clone, Copy)]
struct Frame {
    left: f64,
    top: f64,
    x_max: f64,
    y_max: f64,
}

impl Frame {
    fn x(&self, x: f64) -> f64 {
        self.left + PANEL_WIDTH * x / self.x_max
    }

    fn y(&self, y: f64) -> f64 {
        self.top + PANEL_HEIGHT * (1.0 - y / self.y_max)
    }
}

impl Figure {
    /// The picture.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let n_columns = self.columns.len().max(1) as f64;
        let width = LEFT + n_columns * (PANEL_WIDTH + GAP_X) - GAP_X + RIGHT;
        let per_line = ((width - LEFT - RIGHT) / LEGEND_ENTRY_WIDTH)
            .floor()
            .max(1.0) as usize;
        let legend_height = self.styles.len().div_ceil(per_line) as f64 * LEGEND_LINE_HEIGHT;
        let panels_top = TITLE_HEIGHT + legend_height + HEAD_HEIGHT;
        let panels_bottom = panels_top + self.rows.len() as f64 * (PANEL_HEIGHT + GAP_Y) - GAP_Y;
        let notes: Vec<String> = self
            .notes
            .iter()
            .flat_map(|note| wrapped(note, ((width - LEFT - RIGHT) / NOTE_LETTER_WIDTH) as usize))
            .collect();
        let height = panels_bottom + AXIS_HEIGHT + notes.len() as f64 * NOTE_HEIGHT + 8.0;
        let mut svg = Svg::default();
        svg.open(width, height, &self.title, &self.notes);
        svg.text(LEFT, 19.0, "class=\"title\"", &self.title);
        for (idx, style) in self.styles.iter().enumerate() {
            let x = LEFT + (idx % per_line) as f64 * LEGEND_ENTRY_WIDTH;
            let y = TITLE_HEIGHT + (idx / per_line) as f64 * LEGEND_LINE_HEIGHT + 10.0;
            svg.stroke(&format!("{x:.1},{y:.1} {:.1},{y:.1}", x + 34.0), style);
            svg.text(x + 40.0, y + 4.0, "", &style.name);
        }
        self.draw_panels(&mut svg, panels_top);
        let middle = f64::midpoint(LEFT, width - RIGHT);
        svg.text(
            middle,
            panels_bottom + 34.0,
            "class=\"middle\"",
            &self.x_label,
        );
        for (idx, note) in notes.iter().enumerate() {
            let y = panels_bottom + AXIS_HEIGHT + (idx as f64 + 0.8) * NOTE_HEIGHT;
            svg.text(LEFT, y, "class=\"note\"", note);
        }
        svg.close()
    }

    fn draw_panels(&self, svg: &mut Svg, panels_top: f64) {
        let points = |row: &Row| -> Vec<Point> {
            let lines = row.panels.iter().flatten();
            lines.flat_map(|line| line.points.clone()).collect()
        };
        let x_most = greatest(self.rows.iter().flat_map(points).map(|point| point.x));
        let x_ticks = ticks(x_most);
        for (row_idx, row) in self.rows.iter().enumerate() {
            let top = panels_top + row_idx as f64 * (PANEL_HEIGHT + GAP_Y);
            let y_most = row.y_max.unwrap_or_else(|| {
                greatest(
                    points(row)
                        .iter()
                        .map(|point| point.y + point.half_width.unwrap_or(0.0)),
                )
            });
            let y_ticks = ticks(y_most);
            let middle = top + PANEL_HEIGHT / 2.0;
            let turned = format!("class=\"middle\" transform=\"rotate(-90 14 {middle:.1})\"");
            svg.text(14.0, middle, &turned, &row.label);
            for (idx, (head, lines)) in self.columns.iter().zip(&row.panels).enumerate() {
                let frame = Frame {
                    left: LEFT + idx as f64 * (PANEL_WIDTH + GAP_X),
                    top,
                    x_max: x_ticks.last().copied().unwrap_or(1.0).max(x_most),
                    y_max: y_ticks.last().copied().unwrap_or(1.0).max(y_most),
                };
                if row_idx == 0 {
                    let x = frame.left + PANEL_WIDTH / 2.0;
                    svg.text(x, top - 7.0, "class=\"middle head\"", head);
                }
                svg.axes(
                    &frame,
                    &x_ticks,
                    &y_ticks,
                    idx == 0,
                    row_idx + 1 == self.rows.len(),
                );
                svg.begin_panel(&frame);
                for line in lines {
                    if let Some(style) = self.styles.get(line.style) {
                        svg.band(&frame, line, style);
                    }
                }
                for line in lines {
                    if let Some(style) = self.styles.get(line.style) {
                        let points = line.points.iter();
                        let points = points.map(|point| place(&frame, point.x, point.y));
                        svg.stroke(&points.collect::<Vec<_>>().join(" "), style);
                    }
                }
                svg.end_panel();
            }
        }
    }
}

/// An SVG document under construction.
#[derive(Debug, Default)]
struct Svg {
    text: String,
    n_panels: usize,
}

impl Svg {
    /// Adds a line. A `String` takes whatever is written.
    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        writeln!(self.text, "{line}").ok();
    }

    fn open(&mut self, width: f64, height: f64, title: &str, notes: &[String]) {
        self.line(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
             height=\"{height:.0}\" role=\"img\" aria-labelledby=\"title desc\">"
        ));
        self.line(format_args!(
            "<title id=\"title\">{}</title>",
            escape(title)
        ));
        self.line(format_args!(
            "<desc id=\"desc\">{}</desc>",
            escape(&notes.join(" "))
        ));
        self.line(format_args!(
            "<style>text {{ font: 12px sans-serif; fill: #222 }} .title {{ font-size: 15px; font-weight: bold }} \
             .head {{ font-size: 13px; font-weight: bold }} .middle {{ text-anchor: middle }} .end {{ text-anchor: end }} \
             .note {{ font-size: 11px; fill: #444 }} .grid {{ stroke: #ddd }} \
             .frame {{ fill: none; stroke: #666 }}</style>"
        ));
        self.line(format_args!(
            "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
        ));
    }

    fn close(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn text(&mut self, x: f64, y: f64, attributes: &str, words: &str) {
        let gap = if attributes.is_empty() { "" } else { " " };
        self.line(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\"{gap}{attributes}>{}</text>",
            escape(words)
        ));
    }

    fn axes(
        &mut self,
        frame: &Frame,
        x_ticks: &[f64],
        y_ticks: &[f64],
        is_leftmost: bool,
        is_lowest: bool,
    ) {
        let (left, top) = (frame.left, frame.top);
        let (right, bottom) = (left + PANEL_WIDTH, top + PANEL_HEIGHT);
        for &tick in x_ticks {
            let x = frame.x(tick);
            self.line(format_args!(
                "<path class=\"grid\" d=\"M{x:.1} {top:.1}V{bottom:.1}\"/>"
            ));
            if is_lowest {
                self.text(x, bottom + 15.0, "class=\"middle\"", &tick.to_string());
            }
        }
        for &tick in y_ticks {
            let y = frame.y(tick);
            self.line(format_args!(
                "<path class=\"grid\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>"
            ));
            if is_leftmost {
                self.text(left - 6.0, y + 4.0, "class=\"end\"", &tick.to_string());
            }
        }
        self.line(format_args!(
            "<rect class=\"frame\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{PANEL_WIDTH:.1}\" height=\"{PANEL_HEIGHT:.1}\"/>"
        ));
    }

    /// Begins a group that ends at the panel's sides.
    fn begin_panel(&mut self, frame: &Frame) {
        self.n_panels += 1;
        let (id, left, top) = (self.n_panels, frame.left, frame.top);
        // A hair of room, so that lines at 0 and at the maximum are drawn whole.
        self.line(format_args!(
            "<clipPath id=\"panel{id}\"><rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{PANEL_WIDTH:.1}\" height=\"{:.1}\"/></clipPath>",
            top - 1.5,
            PANEL_HEIGHT + 3.0
        ));
        self.line(format_args!("<g clip-path=\"url(#panel{id})\">"));
    }

    fn end_panel(&mut self) {
        self.line(format_args!("</g>"));
    }

    /// The band around the points that have one.
    fn band(&mut self, frame: &Frame, line: &Line, style: &Style) {
        let edge = |sign: f64| {
            line.points.iter().filter_map(move |point| {
                Some(place(frame, point.x, point.y + sign * point.half_width?))
            })
        };
        let mut lower: Vec<String> = edge(-1.0).collect();
        if lower.len() < 2 {
            return;
        }
        lower.reverse();
        let outline: Vec<String> = edge(1.0).chain(lower).collect();
        self.line(format_args!(
            "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"0.12\"/>",
            outline.join(" "),
            style.color
        ));
    }

    fn stroke(&mut self, points: &str, style: &Style) {
        if points.is_empty() {
            return;
        }
        self.line(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-linejoin=\"round\" \
             stroke-dasharray=\"{}\"/>",
            style.color,
            style.dash.pattern()
        ));
    }
}

fn place(frame: &Frame, x: f64, y: f64) -> String {
    format!("{:.1},{:.1}", frame.x(x), frame.y(y))
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// A text in lines of at most so many letters, cut between words.
fn wrapped(text: &str, n_letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= n_letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests;
