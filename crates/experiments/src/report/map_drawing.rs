//! The map as SVG: occupancy, navigation regions, objects and the way driven.
//!
//! The drawing is in metres with y down, so a point (x, y) of the map's frame lies at (x - left, top - y). Cells are
//! drawn as one path per shade, a stretch of equal cells in a row being one rectangle.

use factotum_protocol::{Aosm, CELL_UNKNOWN, MapError, OccupancyMap, Pose};

use super::html::escape;

/// A cell this likely to be occupied is drawn as a wall, as in ROS map files.
const OCCUPIED_PERCENT: i8 = 65;
/// Room around what is known, metres.
const MARGIN_M: f64 = 0.3;

/// Colours of navigation regions: the palette of M. Okabe and K. Ito, which colour-blind people can tell apart.
const REGION_COLORS: [&str; 6] = [
    "#e69f00", "#56b4e9", "#009e73", "#f0e442", "#d55e00", "#cc79a7",
];

/// A figure with the drawing and its legend.
pub(super) fn draw(
    map: &OccupancyMap,
    aosm: &Aosm,
    way_driven: &[[f64; 2]],
) -> Result<String, MapError> {
    let cells = map.cells()?;
    let frame = Frame::around(map, &cells);
    let mut svg = String::new();
    let (width, height) = (frame.right - frame.left, frame.top - frame.bottom);
    let words = "Map of the home with navigation regions, objects and the way the robot drove";
    put(
        &mut svg,
        format_args!(
            "<figure>\n<svg viewBox=\"0 0 {width:.2} {height:.2}\" role=\"img\" aria-label=\"{words}\">\n"
        ),
    );
    draw_cells(&mut svg, map, &cells, &frame);
    for region in &aosm.regions {
        let mut arrows = String::new();
        for &[x, y, yaw] in &region.poses {
            put_arrow(&mut arrows, &frame, [x, y], yaw);
        }
        let (color, name) = (region_color(region.colour_index), escape(&region.name));
        put(
            &mut svg,
            format_args!(
                "<path d=\"{arrows}\" fill=\"{color}\" fill-opacity=\".75\"><title>{name}</title></path>\n"
            ),
        );
    }
    draw_way(&mut svg, &frame, way_driven);
    for object in &aosm.objects {
        draw_object(&mut svg, &frame, &object.name, &object.pose);
    }
    svg.push_str("</svg>\n");
    draw_legend(&mut svg, aosm, !way_driven.is_empty());
    svg.push_str("</figure>\n");
    Ok(svg)
}

/// The part of the world that is drawn, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Frame {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
}

impl Frame {
    /// The known cells and a margin; the whole map when nothing is known.
    fn around(map: &OccupancyMap, cells: &[i8]) -> Self {
        let width = map.width.max(1) as usize;
        let known = || {
            cells
                .iter()
                .enumerate()
                .filter(|(_, cell)| **cell != CELL_UNKNOWN)
                .map(|(i, _)| (i % width, i / width))
        };
        let span = |values: &mut dyn Iterator<Item = usize>, all: u32| {
            values
                .fold(None, |span: Option<(usize, usize)>, v| {
                    Some(span.map_or((v, v), |(a, b)| (a.min(v), b.max(v))))
                })
                .map_or((0.0, f64::from(all)), |(first, last)| {
                    (first as f64, last as f64 + 1.0)
                })
        };
        let (column_first, column_end) = span(&mut known().map(|(column, _)| column), map.width);
        let (row_first, row_end) = span(&mut known().map(|(_, row)| row), map.height);
        let corners = [
            (column_first, row_first),
            (column_end, row_first),
            (column_first, row_end),
            (column_end, row_end),
        ]
        .map(|(column, row)| world_from_cell(map, column, row));
        let least = |axis: usize| {
            corners
                .iter()
                .map(|corner| corner[axis])
                .fold(f64::INFINITY, f64::min)
                - MARGIN_M
        };
        let most = |axis: usize| {
            corners
                .iter()
                .map(|corner| corner[axis])
                .fold(f64::NEG_INFINITY, f64::max)
                + MARGIN_M
        };
        Self {
            left: least(0),
            right: most(0),
            bottom: least(1),
            top: most(1),
        }
    }

    /// Where a point of the map's frame lies on the drawing.
    fn drawn(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x - self.left, self.top - y]
    }
}

/// The point of the map's frame at a column and row, corners of cells being whole numbers.
fn world_from_cell(map: &OccupancyMap, column: f64, row: f64) -> [f64; 2] {
    let (sin, cos) = map.origin.yaw.sin_cos();
    let (x, y) = (column * map.resolution_m, row * map.resolution_m);
    [
        map.origin.x + cos * x - sin * y,
        map.origin.y + sin * x + cos * y,
    ]
}

fn draw_cells(svg: &mut String, map: &OccupancyMap, cells: &[i8], frame: &Frame) {
    // Cells to drawing: scale, turn by the origin's yaw, flip y, move.
    let (sin, cos) = map.origin.yaw.sin_cos();
    let scale = map.resolution_m;
    let [x, y] = frame.drawn([map.origin.x, map.origin.y]);
    put(
        svg,
        format_args!(
            "<g shape-rendering=\"crispEdges\" transform=\"matrix({:.6} {:.6} {:.6} {:.6} {x:.4} {y:.4})\">\n",
            scale * cos,
            -scale * sin,
            -scale * sin,
            -scale * cos,
        ),
    );
    let is_occupied = |cell: i8| cell >= OCCUPIED_PERCENT;
    for (color, is_drawn) in [
        (
            "#ffffff",
            &(|cell: i8| cell != CELL_UNKNOWN && !is_occupied(cell)) as &dyn Fn(i8) -> bool,
        ),
        ("#2b3238", &is_occupied),
    ] {
        put(
            svg,
            format_args!(
                "<path fill=\"{color}\" d=\"{}\"/>\n",
                stretches(map.width as usize, cells, is_drawn)
            ),
        );
    }
    svg.push_str("</g>\n");
}

/// A path with one rectangle for each stretch of cells in a row that are to be drawn.
fn stretches(width: usize, cells: &[i8], is_drawn: &dyn Fn(i8) -> bool) -> String {
    let mut path = String::new();
    for (row_idx, row) in cells.chunks(width.max(1)).enumerate() {
        let mut column = 0;
        while column < row.len() {
            let length = row[column..]
                .iter()
                .take_while(|&&cell| is_drawn(cell))
                .count();
            if length > 0 {
                put(
                    &mut path,
                    format_args!("M{column} {row_idx}h{length}v1h-{length}z"),
                );
            }
            column += length.max(1);
        }
    }
    path
}

fn draw_way(svg: &mut String, frame: &Frame, way_driven: &[[f64; 2]]) {
    let (Some(&first), Some(&last)) = (way_driven.first(), way_driven.last()) else {
        return;
    };
    let mut points = String::new();
    for &point in way_driven {
        let [x, y] = frame.drawn(point);
        put(&mut points, format_args!("{x:.2},{y:.2} "));
    }
    put(
        svg,
        format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\".05\" stroke-linejoin=\"round\"/>\n",
            points.trim_end(),
        ),
    );
    for (point, fill, words) in [(first, "#ffffff", "start"), (last, "#0072b2", "end")] {
        let [x, y] = frame.drawn(point);
        put(
            svg,
            format_args!(
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\".1\" fill=\"{fill}\" stroke=\"#0072b2\" stroke-width=\".04\"><title>{words}</title></circle>\n",
            ),
        );
    }
}

fn draw_object(svg: &mut String, frame: &Frame, name: &str, pose: &Pose) {
    let [x, y] = frame.drawn([pose.position[0], pose.position[1]]);
    let name = escape(name);
    put(
        svg,
        format_args!(
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\".14\" height=\".14\" fill=\"#1c2126\" stroke=\"#ffffff\" stroke-width=\".03\"/>\n",
            x - 0.07,
            y - 0.07,
        ),
    );
    put(
        svg,
        format_args!(
            "<text x=\"{:.2}\" y=\"{:.2}\" font-size=\".2\" font-family=\"system-ui, sans-serif\" fill=\"#1c2126\" stroke=\"#ffffff\" stroke-width=\".06\" paint-order=\"stroke\">{name}</text>\n",
            x + 0.12,
            y + 0.07,
        ),
    );
}

/// A slim triangle that points along the heading.
fn put_arrow(path: &mut String, frame: &Frame, at: [f64; 2], yaw: f64) {
    let (sin, cos) = yaw.sin_cos();
    let corner = |along: f64, across: f64| {
        frame.drawn([
            at[0] + along * cos - across * sin,
            at[1] + along * sin + across * cos,
        ])
    };
    for (command, [x, y]) in [
        ('M', corner(0.12, 0.0)),
        ('L', corner(-0.06, 0.05)),
        ('L', corner(-0.06, -0.05)),
    ] {
        put(path, format_args!("{command}{x:.2} {y:.2}"));
    }
    path.push('z');
}

fn draw_legend(svg: &mut String, aosm: &Aosm, has_way: bool) {
    svg.push_str("<figcaption>");
    for region in &aosm.regions {
        let (color, words) = (region_color(region.colour_index), escape(&region.option));
        let object = escape(&region.object);
        put(
            svg,
            format_args!("<span><i style=\"background:{color}\"></i>{words} {object}</span>\n"),
        );
    }
    if has_way {
        svg.push_str("<span><i style=\"background:#0072b2\"></i>way driven</span>\n");
    }
    svg.push_str("<span><i style=\"background:#2b3238\"></i>occupied</span>\n");
    svg.push_str("<span><i style=\"background:#c9cfd4\"></i>unknown</span></figcaption>\n");
}

fn region_color(colour_index: u32) -> &'static str {
    REGION_COLORS[colour_index as usize % REGION_COLORS.len()]
}

/// Appends formatted text.
fn put(text: &mut String, words: std::fmt::Arguments<'_>) {
    text.push_str(&std::fmt::format(words));
}

#[cfg(test)]
mod tests {
    use factotum_protocol::PosePlanar;

    use super::*;

    #[test]
    fn stretches_cover_the_drawn_cells_and_no_others() {
        let path = stretches(4, &[0, 0, 100, 0, 100, 100, 100, 100], &|cell| cell == 0);
        assert_eq!(path, "M0 0h2v1h-2zM3 0h1v1h-1z");
    }

    #[test]
    fn the_drawing_is_cropped_to_what_is_known() {
        let origin = PosePlanar {
            x: -5.0,
            y: -5.0,
            yaw: 0.0,
        };
        let mut cells = vec![CELL_UNKNOWN; 100];
        cells[45] = 0;
        let map = OccupancyMap::from_cells(10, 10, 1.0, origin, &cells).unwrap();
        let frame = Frame::around(&map, &cells);
        assert_eq!(
            frame,
            Frame {
                left: -0.3,
                right: 1.3,
                bottom: -1.3,
                top: 0.3
            }
        );
        // y points up in the world and down on the page.
        assert_eq!(frame.drawn([0.7, -0.7]), [1.0, 1.0]);
    }

    #[test]
    fn a_map_of_which_nothing_is_known_is_drawn_whole() {
        let origin = PosePlanar {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
        };
        let map = OccupancyMap::from_cells(4, 2, 0.5, origin, &[CELL_UNKNOWN; 8]).unwrap();
        let frame = Frame::around(&map, &map.cells().unwrap());
        assert_eq!(
            frame,
            Frame {
                left: -0.3,
                right: 2.3,
                bottom: -0.3,
                top: 1.3
            }
        );
    }

    #[test]
    fn a_turned_map_keeps_its_cells_where_they_are() {
        let origin = PosePlanar {
            x: 1.0,
            y: 2.0,
            yaw: std::f64::consts::FRAC_PI_2,
        };
        let map = OccupancyMap::from_cells(2, 1, 1.0, origin, &[0, 0]).unwrap();
        let [x, y] = world_from_cell(&map, 2.0, 1.0);
        assert!(
            (x - 0.0).abs() < 1e-12 && (y - 4.0).abs() < 1e-12,
            "({x}, {y})"
        );
    }
}
