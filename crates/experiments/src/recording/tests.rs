use std::collections::BTreeMap;

use factotum_geometry::Pose2;
use factotum_protocol::{
    AosmObject, Body, BodyPose, Geometry, NavigationRegion, Pose, PosePlanar, SceneSource, Shape,
};
use mcap::{MessageStream, Summary};
use serde_json::Value;

use super::*;

fn body(name: &str, geometries: Vec<Geometry>) -> Body {
    let shapes = geometries
        .into_iter()
        .map(|geometry| Shape {
            geometry,
            pose: Pose::IDENTITY,
            rgba: [0.5, 0.5, 0.5, 1.0],
        })
        .collect();
    Body {
        name: name.to_owned(),
        pose: Pose::IDENTITY,
        shapes,
    }
}

fn state(time_secs: f64) -> ServerMessage {
    let pose = Pose {
        position: [time_secs, 0.0, 0.5],
        ..Pose::IDENTITY
    };
    ServerMessage::State(State {
        time_secs,
        sim_speed: 1.0,
        base: PosePlanar {
            x: time_secs,
            y: 0.0,
            yaw: 0.0,
        },
        body_poses: vec![BodyPose {
            name: "bottle".to_owned(),
            pose,
        }],
        joints: vec![],
    })
}

/// A recording of everything there is to record, over ten seconds.
fn record_everything(file: &Path) {
    let mut recording = Recording::create(file, UtcTime::from_unix_secs(1_000)).unwrap();
    let geometries = vec![
        Geometry::Box {
            half_extents_m: [0.1, 0.2, 0.3],
        },
        Geometry::Sphere { radius_m: 0.1 },
        Geometry::Capsule {
            radius_m: 0.1,
            half_length_m: 0.2,
        },
        Geometry::Cylinder {
            radius_m: 0.1,
            half_length_m: 0.2,
        },
        Geometry::Ellipsoid {
            radii_m: [0.1, 0.2, 0.3],
        },
        Geometry::Plane {
            half_extents_m: [0.0, 0.0],
        },
        Geometry::Mesh {
            vertices: vec![0.0; 9],
            triangles: vec![0, 1, 2],
        },
    ];
    let scene = Scene {
        source: SceneSource::Home,
        bodies: vec![body("bottle", geometries)],
    };
    let origin = PosePlanar {
        x: -1.0,
        y: -1.0,
        yaw: 0.0,
    };
    let map = OccupancyMap::from_cells(2, 2, 0.05, origin, &[CELL_FREE, 100, -1, 50]).unwrap();
    let aosm = Aosm {
        objects: vec![AosmObject {
            name: "bottle".to_owned(),
            class: "bottle".to_owned(),
            pose: Pose::IDENTITY,
            state: String::new(),
        }],
        regions: vec![NavigationRegion {
            name: "by_table".to_owned(),
            option: "pick".to_owned(),
            object: "bottle".to_owned(),
            colour_index: 7,
            poses: vec![[0.0, 0.0, 1.0]],
        }],
        ..Aosm::default()
    };
    let scan = LaserScan {
        angle_min_rad: -1.0,
        angle_step_rad: 1.0,
        ranges_m: vec![1.0, f64::INFINITY, 2.0],
        range_min_m: 0.1,
        range_max_m: 12.0,
        base_from_lidar: Pose2::identity(),
    };
    recording.record(0.0, &ServerMessage::Scene(scene)).unwrap();
    recording.record(0.0, &ServerMessage::Map(map)).unwrap();
    recording.record(0.0, &ServerMessage::Aosm(aosm)).unwrap();
    recording
        .record(0.0, &ServerMessage::Plan(Plan::default()))
        .unwrap();
    recording
        .record(
            0.0,
            &ServerMessage::BasePath(BasePath {
                points: vec![[0.0, 0.0], [1.0, 0.0]],
            }),
        )
        .unwrap();
    recording.scan(0.0, &scan).unwrap();
    let event = Event {
        level: EventLevel::Warning,
        text: "the bottle slipped".to_owned(),
        time_secs: 1.5,
    };
    recording.record(0.0, &ServerMessage::Event(event)).unwrap();
    for tick in 0..100 {
        recording
            .record(f64::from(tick) * 0.1, &state(f64::from(tick) * 0.1))
            .unwrap();
    }
    let done = Done {
        achieved: true,
        summary: "the bottle is in the bin".to_owned(),
    };
    recording.record(10.0, &ServerMessage::Done(done)).unwrap();
    recording.finish().unwrap();
}

const CELL_FREE: i8 = 0;

/// The messages that a reader gets before the file ends or breaks, by topic.
fn messages(bytes: &[u8]) -> BTreeMap<String, Vec<Value>> {
    let options = mcap::read::Options::IgnoreEndMagic.into();
    let mut by_topic: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    let Ok(stream) = MessageStream::new_with_options(bytes, options) else {
        return by_topic;
    };
    for message in stream.map_while(Result::ok) {
        let value = serde_json::from_slice(&message.data).unwrap();
        by_topic
            .entry(message.channel.topic.clone())
            .or_default()
            .push(value);
    }
    by_topic
}

#[test]
fn every_topic_is_there_under_its_schema() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    record_everything(&file);
    let bytes = std::fs::read(&file).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.channels.len(), Topic::ALL.len());
    let mut channels: Vec<_> = summary.channels.values().collect();
    channels.sort_by_key(|channel| channel.id);
    for channel in channels {
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(channel.message_encoding, "json");
        assert_eq!(schema.encoding, "jsonschema");
        let text: Value = serde_json::from_slice(&schema.data).unwrap();
        assert_eq!(text["title"], schema.name.as_str());
        assert_eq!(
            text["type"], "object",
            "Foxglove wants an object at the top"
        );
    }
    let by_topic = messages(&bytes);
    assert_eq!(
        by_topic["/tf"].len(),
        101,
        "the scene's poses and a hundred states"
    );
    for topic in [
        "/scene", "/map", "/aosm", "/path", "/scan", "/log", "/plan", "/done",
    ] {
        assert_eq!(by_topic[topic].len(), 1, "{topic}");
    }
}

/// Whether a message has all fields that its schema requires, at every depth, with the types it names.
fn assert_conforms(message: &Value, schema: &Value, place: &str) {
    match schema["type"].as_str() {
        Some("object") => {
            for name in schema["required"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(Value::as_str)
            {
                let field = message
                    .get(name)
                    .unwrap_or_else(|| panic!("{place} has no `{name}`"));
                assert_conforms(
                    field,
                    &schema["properties"][name],
                    &format!("{place}.{name}"),
                );
            }
        }
        Some("array") => {
            for item in message
                .as_array()
                .unwrap_or_else(|| panic!("{place} is no list"))
            {
                assert_conforms(item, &schema["items"], &format!("{place}[]"));
            }
        }
        Some("number") => assert!(message.is_number(), "{place} is {message}"),
        Some("integer") => assert!(message.is_u64(), "{place} is {message}"),
        Some("string") => assert!(message.is_string(), "{place} is {message}"),
        Some("boolean") => assert!(message.is_boolean(), "{place} is {message}"),
        other => panic!("{place} has a schema of type {other:?}"),
    }
}

#[test]
fn every_message_conforms_to_its_schema() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    record_everything(&file);
    let by_topic = messages(&std::fs::read(&file).unwrap());
    for topic in Topic::ALL {
        for message in by_topic.get(topic.name()).into_iter().flatten() {
            assert_conforms(message, &schemas::of(topic.schema_name()), topic.name());
        }
    }
}

#[test]
fn a_recording_cut_anywhere_is_readable_up_to_its_last_whole_second() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    record_everything(&file);
    let bytes = std::fs::read(&file).unwrap();
    let whole = messages(&bytes)["/tf"].len();
    let mut best_so_far = 0;
    for twentieth in 1..=20 {
        let cut = messages(&bytes[..bytes.len() * twentieth / 20]);
        let n_messages = cut.get("/tf").map_or(0, Vec::len);
        assert!(
            n_messages >= best_so_far,
            "a longer file has no fewer messages"
        );
        best_so_far = n_messages;
    }
    assert_eq!(best_so_far, whole);
    // Half the file holds about half the messages; a chunk of a second is the most that is lost.
    let half = messages(&bytes[..bytes.len() / 2]);
    assert!(
        half["/tf"].len() >= whole / 4,
        "{} of {whole}",
        half["/tf"].len()
    );
}

#[test]
fn a_crash_loses_at_most_a_second() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    let mut recording = Recording::create(&file, UtcTime::from_unix_secs(1_000)).unwrap();
    for tick in 0..=100 {
        recording
            .record(0.0, &state(f64::from(tick) * 0.1))
            .unwrap();
    }
    // What is on the disk now is what a `kill -9` leaves.
    let on_disk = messages(&std::fs::read(&file).unwrap());
    std::mem::drop(recording);
    let last = on_disk["/tf"].last().unwrap();
    let secs = last["transforms"][0]["timestamp"]["sec"].as_u64().unwrap();
    assert!(
        secs >= 1_009,
        "the last message on disk is of second {secs}, ten seconds after 1000 were recorded"
    );
}

#[test]
fn a_scan_without_return_has_range_zero() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    record_everything(&file);
    let scan = &messages(&std::fs::read(&file).unwrap())["/scan"][0];
    assert_eq!(scan["ranges"], serde_json::json!([1.0, 0.0, 2.0]));
    assert_eq!(scan["end_angle"], 1.0);
}

#[test]
fn a_capsule_becomes_a_cylinder_with_a_ball_at_each_end() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    let mut recording = Recording::create(&file, UtcTime::from_unix_secs(0)).unwrap();
    let lying = Shape {
        geometry: Geometry::Capsule {
            radius_m: 0.1,
            half_length_m: 0.5,
        },
        // Turned by a quarter about y, so that z points along x.
        pose: Pose {
            position: [1.0, 2.0, 3.0],
            orientation_xyzw: [0.0, 0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt()],
        },
        rgba: [1.0; 4],
    };
    let bodies = vec![Body {
        shapes: vec![lying],
        ..body("link", vec![])
    }];
    recording
        .record(
            0.0,
            &ServerMessage::Scene(Scene {
                source: SceneSource::Robot,
                bodies,
            }),
        )
        .unwrap();
    recording.finish().unwrap();
    let scene = &messages(&std::fs::read(&file).unwrap())["/scene"][0];
    let spheres = scene["entities"][0]["spheres"].as_array().unwrap();
    let x = |i: usize| spheres[i]["pose"]["position"]["x"].as_f64().unwrap();
    assert!(
        (x(0) - 1.5).abs() < 1e-12 && (x(1) - 0.5).abs() < 1e-12,
        "{spheres:?}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    std::os::unix::fs::symlink("/dev/full", &file).unwrap();
    let error = Recording::create(&file, UtcTime::from_unix_secs(0)).unwrap_err();
    assert!(
        matches!(
            error,
            RecordingError::Storage(StorageError::DiskFull { .. })
        ),
        "{error:?}"
    );
    assert!(error.to_string().contains("run.mcap"), "{error}");
}

#[test]
fn only_what_moved_is_written_and_all_of_it_once_a_second() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    let mut recording = Recording::create(&file, UtcTime::from_unix_secs(0)).unwrap();
    let bodies = vec![body("bottle", vec![]), body("wall", vec![])];
    let scene = Scene {
        source: SceneSource::Home,
        bodies,
    };
    recording.record(0.0, &ServerMessage::Scene(scene)).unwrap();
    for tick in 0..30 {
        recording
            .record(0.0, &state(f64::from(tick) * 0.1))
            .unwrap();
    }
    recording.finish().unwrap();
    let n_frames: Vec<usize> = messages(&std::fs::read(&file).unwrap())["/tf"]
        .iter()
        .map(|message| message["transforms"].as_array().unwrap().len())
        .collect();
    let n_whole = n_frames.iter().filter(|n| **n == 3).count();
    assert!(
        (3..=5).contains(&n_whole),
        "wall, bottle and base {n_whole} times in three seconds"
    );
    assert!(n_frames.iter().all(|n| [2, 3].contains(n)), "{n_frames:?}");
}

#[test]
fn a_body_that_left_its_scene_is_taken_away() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    let mut recording = Recording::create(&file, UtcTime::from_unix_secs(0)).unwrap();
    for names in [&["bottle", "bin"][..], &["bin"][..]] {
        let bodies = names.iter().map(|name| body(name, vec![])).collect();
        let scene = Scene {
            source: SceneSource::Belief,
            bodies,
        };
        recording.record(0.0, &ServerMessage::Scene(scene)).unwrap();
    }
    recording.finish().unwrap();
    let scenes = &messages(&std::fs::read(&file).unwrap())["/scene"];
    assert_eq!(scenes[0]["deletions"], serde_json::json!([]));
    assert_eq!(scenes[1]["deletions"][0]["id"], "bottle");
    assert_eq!(scenes[1]["deletions"].as_array().unwrap().len(), 1);
}
