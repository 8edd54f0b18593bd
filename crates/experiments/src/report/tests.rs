use factotum_protocol::{AosmObject, NavigationRegion, PlanStep, Pose, PosePlanar, StepKind};

use super::*;

/// A report with everything in it, words that would break HTML included.
fn full_report() -> Report {
    let (width, height) = (120_u32, 80_u32);
    let cells: Vec<i8> = (0..width * height)
        .map(|i| {
            let (column, row) = (i % width, i / width);
            let is_wall = column < 2 || row < 2 || column >= width - 2 || row >= height - 2;
            let is_divider = (58..60).contains(&column) && !(30..50).contains(&row);
            let is_table = (20..34).contains(&column) && (50..62).contains(&row);
            if is_wall || is_divider || is_table {
                100
            } else {
                0
            }
        })
        .collect();
    let origin = PosePlanar {
        x: -3.0,
        y: -2.0,
        yaw: 0.0,
    };
    let object = |name: &str, x: f64, y: f64| AosmObject {
        name: name.to_owned(),
        class: name.to_owned(),
        pose: Pose {
            position: [x, y, 0.8],
            ..Pose::IDENTITY
        },
        state: String::new(),
    };
    let region =
        |name: &str, option: &str, object: &str, colour_index, center: [f64; 2]| NavigationRegion {
            name: name.to_owned(),
            option: option.to_owned(),
            object: object.to_owned(),
            colour_index,
            poses: (0..24)
                .map(|i| {
                    let angle = f64::from(i) * std::f64::consts::TAU / 24.0;
                    let radius = 0.55 + 0.1 * f64::from(i % 3);
                    [
                        center[0] + radius * angle.cos(),
                        center[1] + radius * angle.sin(),
                        angle + std::f64::consts::PI,
                    ]
                })
                .collect(),
        };
    let step = |index, kind, action: &str, args: &[&str], state, reason: &str| PlanStep {
        index,
        kind,
        action: action.to_owned(),
        args: args.iter().map(|&arg| arg.to_owned()).collect(),
        state,
        attempts: 1,
        reason: reason.to_owned(),
    };
    let executed =
        |action: &str, args: &[&str], is_done, reason: &str, attempts, robot_secs| ExecutedStep {
            action: action.to_owned(),
            args: args.iter().map(|&arg| arg.to_owned()).collect(),
            is_done,
            reason: reason.to_owned(),
            attempts,
            robot_secs,
        };
    Report {
        title: "Throw the bottle away".to_owned(),
        verdict: Verdict::Achieved,
        summary: "The bottle is in the bin; the first grasp slipped and the second held."
            .to_owned(),
        facts: vec![
            Fact::new("command", "factotum run --headless --seed 1"),
            Fact::new("seed", 1),
        ],
        map: Some(OccupancyMap::from_cells(width, height, 0.05, origin, &cells).unwrap()),
        aosm: Aosm {
            objects: vec![object("bottle <1>", -1.6, 0.8), object("bin", 1.9, -1.2)],
            regions: vec![
                region("by_bottle", "pick", "bottle", 0, [-1.6, 0.8]),
                region("by_bin", "drop", "bin", 2, [1.9, -1.2]),
            ],
            ..Aosm::default()
        },
        way_driven: (0..60)
            .map(|i| f64::from(i) / 59.0)
            .map(|t| [-2.2 + 4.0 * t, -0.2 + 0.6 * (6.0 * t).sin()])
            .collect(),
        plan: Plan {
            replans: 1,
            steps: vec![
                step(
                    0,
                    StepKind::Navigate,
                    "navigate",
                    &["by_bottle"],
                    StepState::Done,
                    "",
                ),
                step(
                    1,
                    StepKind::Manipulate,
                    "pick",
                    &["bottle", "table"],
                    StepState::Done,
                    "took another grasp",
                ),
                step(
                    2,
                    StepKind::Navigate,
                    "navigate",
                    &["by_bin"],
                    StepState::Done,
                    "",
                ),
                step(
                    3,
                    StepKind::Manipulate,
                    "drop",
                    &["bottle", "bin"],
                    StepState::Done,
                    "",
                ),
            ],
        },
        executed: vec![
            executed("navigate", &["by_bottle"], true, "", 1, 6.2),
            executed(
                "pick",
                &["bottle", "table"],
                false,
                "the bottle slipped out of the fingers",
                1,
                5.1,
            ),
            executed("pick", &["bottle", "table"], true, "", 2, 5.4),
            executed("navigate", &["by_bin"], true, "", 1, 9.0),
            executed("drop", &["bottle", "bin"], true, "", 1, 3.9),
        ],
        timings: [("exploring", 41.0), ("planning", 0.3), ("acting", 29.6)]
            .map(|(name, secs)| Timing {
                name: name.to_owned(),
                secs,
            })
            .to_vec(),
        figures: vec![
            Fact::new("map overlap (IoU)", "0.93"),
            Fact::new("peak memory", "212 MB"),
        ],
        events: vec![
            Event {
                level: EventLevel::Info,
                text: "the map is complete".to_owned(),
                time_secs: 41.0,
            },
            Event {
                level: EventLevel::Warning,
                text: "the bottle slipped & fell".to_owned(),
                time_secs: 52.3,
            },
        ],
    }
}

/// Every element that is opened is closed, in order.
fn assert_well_formed(html: &str) {
    const VOID: [&str; 3] = ["!doctype", "meta", "br"];
    let mut open = Vec::new();
    for tag in html
        .split('<')
        .skip(1)
        .filter_map(|rest| rest.split('>').next())
    {
        let name = tag.split_whitespace().next().unwrap_or_default();
        if let Some(closed) = name.strip_prefix('/') {
            assert_eq!(
                open.pop(),
                Some(closed),
                "</{closed}> closes another element"
            );
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

#[test]
fn a_full_report_is_well_formed_and_needs_nothing_else() {
    let html = full_report().to_html().unwrap();
    assert_well_formed(&html);
    for outside in ["http:", "https:", "src=", "<script", "<link", "url("] {
        assert!(!html.contains(outside), "the page refers to `{outside}`");
    }
    // To look at it: FACTOTUM_KEEP_REPORT=page.html cargo test -p factotum-experiments report
    if let Some(place) = std::env::var_os("FACTOTUM_KEEP_REPORT") {
        std::fs::write(place, html).unwrap();
    }
}

#[test]
fn words_are_escaped() {
    let html = full_report().to_html().unwrap();
    assert!(html.contains("bottle &lt;1&gt;"));
    assert!(html.contains("slipped &amp; fell"));
    assert!(!html.contains("bottle <1>"));
}

#[test]
fn failures_are_told_with_their_reason() {
    let html = full_report().to_html().unwrap();
    assert!(html.contains("the bottle slipped out of the fingers"));
    assert!(html.contains("Planned anew once"));
    let failed = Report {
        verdict: Verdict::NotAchieved,
        ..full_report()
    }
    .to_html()
    .unwrap();
    assert!(failed.contains(">not achieved<"));
}

#[test]
fn an_empty_report_is_a_page_still() {
    let html = Report::default().to_html().unwrap();
    assert_well_formed(&html);
    assert!(html.contains("not judged"));
    assert!(!html.contains("<section>"));
}

#[test]
fn a_broken_map_is_an_error() {
    let mut report = full_report();
    if let Some(map) = &mut report.map {
        map.runs.pop();
    }
    assert!(report.to_html().is_err());
}
