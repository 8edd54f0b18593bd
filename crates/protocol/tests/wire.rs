//! What the wire promises: the shape of each message, round trips, and refusal of what is not ours.

use factotum_protocol::{
    Activity, Aosm, BasePath, Body, BodyPose, ClientMessage, Control, Done, Drive, Evaluation,
    Event, EventLevel, Geometry, Hello, JointPosition, MapError, NavigationRegion, OccupancyMap,
    Plan, PlanStep, Pose, PosePlanar, Role, Scene, SceneSource, ServerMessage, Shape, State,
    Status, StepKind, StepState, Training, Trainings, typescript,
};
use proptest::prelude::*;

const ORIGIN: PosePlanar = PosePlanar {
    x: -1.0,
    y: 2.5,
    yaw: 0.0,
};

fn example_messages() -> Vec<(ServerMessage, &'static str)> {
    vec![
        (
            ServerMessage::Hello(Hello {
                version: 3,
                session: "5eed".to_owned(),
                client: "3f2a9c-1".to_owned(),
                role: Role::Teach,
            }),
            r#"{"type":"hello","version":3,"session":"5eed","client":"3f2a9c-1","role":"teach"}"#,
        ),
        (
            ServerMessage::Scene(Scene {
                source: SceneSource::Home,
                bodies: vec![Body {
                    name: "bin".to_owned(),
                    pose: Pose::IDENTITY,
                    shapes: vec![Shape {
                        geometry: Geometry::Cylinder {
                            radius_m: 0.25,
                            half_length_m: 0.5,
                        },
                        pose: Pose::IDENTITY,
                        rgba: [0.5, 0.5, 0.5, 1.0],
                    }],
                }],
            }),
            r#"{"type":"scene","source":"home","bodies":[{"name":"bin","pose":{"position":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]},"shapes":[{"geometry":{"kind":"cylinder","radius_m":0.25,"half_length_m":0.5},"pose":{"position":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]},"rgba":[0.5,0.5,0.5,1.0]}]}]}"#,
        ),
        (
            ServerMessage::State(State {
                time_secs: 1.5,
                sim_speed: 2.0,
                base: ORIGIN,
                body_poses: vec![BodyPose {
                    name: "bottle".to_owned(),
                    pose: Pose::IDENTITY,
                }],
                joints: vec![JointPosition {
                    name: "lift".to_owned(),
                    position: 0.25,
                }],
            }),
            r#"{"type":"state","time_secs":1.5,"sim_speed":2.0,"base":{"x":-1.0,"y":2.5,"yaw":0.0},"body_poses":[{"name":"bottle","pose":{"position":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]}}],"joints":[{"name":"lift","position":0.25}]}"#,
        ),
        (
            ServerMessage::Map(OccupancyMap {
                width: 3,
                height: 1,
                resolution_m: 0.05,
                origin: ORIGIN,
                runs: vec![-1, 2, 100, 1],
            }),
            r#"{"type":"map","width":3,"height":1,"resolution_m":0.05,"origin":{"x":-1.0,"y":2.5,"yaw":0.0},"runs":[-1,2,100,1]}"#,
        ),
        (
            ServerMessage::Aosm(Aosm {
                regions: vec![NavigationRegion {
                    name: "n_1".to_owned(),
                    option: "pick up the bottle".to_owned(),
                    object: "bottle".to_owned(),
                    colour_index: 0,
                    poses: vec![[1.0, 2.0, 0.5]],
                }],
                ..Aosm::default()
            }),
            r#"{"type":"aosm","classes":[],"objects":[],"regions":[{"name":"n_1","option":"pick up the bottle","object":"bottle","colour_index":0,"poses":[[1.0,2.0,0.5]]}],"edges":[]}"#,
        ),
        (
            ServerMessage::Plan(Plan {
                replans: 1,
                steps: vec![PlanStep {
                    index: 0,
                    kind: StepKind::Manipulate,
                    action: "pick".to_owned(),
                    args: vec!["bottle".to_owned()],
                    state: StepState::Failed,
                    attempts: 3,
                    reason: "the grasp slipped".to_owned(),
                }],
            }),
            r#"{"type":"plan","replans":1,"steps":[{"index":0,"kind":"manipulate","action":"pick","args":["bottle"],"state":"failed","attempts":3,"reason":"the grasp slipped"}]}"#,
        ),
        (
            ServerMessage::BasePath(BasePath {
                points: vec![[0.0, 1.0]],
            }),
            r#"{"type":"base_path","points":[[0.0,1.0]]}"#,
        ),
        (
            ServerMessage::Status(Status {
                goal: "bottle in bin".to_owned(),
                activity: Activity::Exploring,
                paused: false,
                takes_driving: true,
            }),
            r#"{"type":"status","goal":"bottle in bin","activity":"exploring","paused":false,"takes_driving":true}"#,
        ),
        (
            ServerMessage::Event(Event {
                level: EventLevel::Warning,
                text: "the path is blocked".to_owned(),
                time_secs: 12.5,
            }),
            r#"{"type":"event","level":"warning","text":"the path is blocked","time_secs":12.5}"#,
        ),
        (
            ServerMessage::Done(Done {
                achieved: true,
                summary: "the bottle is in the bin".to_owned(),
            }),
            r#"{"type":"done","achieved":true,"summary":"the bottle is in the bin"}"#,
        ),
        (
            ServerMessage::Trainings(Trainings {
                trainings: vec![Training {
                    name: "door-cip-0".to_owned(),
                    task: "door".to_owned(),
                    ablation: "cip".to_owned(),
                    seed: u64::MAX.to_string(),
                    running: true,
                    episodes: 11,
                    env_steps: 350,
                    violations: 1,
                    recent_success_rate: None,
                    evaluations: vec![Evaluation {
                        episode: 10,
                        success_rate: 0.5,
                        violation_rate: 0.0,
                        peak_force_n: 62.5,
                        time_to_success_secs: Some(1.5),
                    }],
                }],
            }),
            r#"{"type":"trainings","trainings":[{"name":"door-cip-0","task":"door","ablation":"cip","seed":"18446744073709551615","running":true,"episodes":11,"env_steps":350,"violations":1,"recent_success_rate":null,"evaluations":[{"episode":10,"success_rate":0.5,"violation_rate":0.0,"peak_force_n":62.5,"time_to_success_secs":1.5}]}]}"#,
        ),
        (
            ServerMessage::Control(Control { owner: None }),
            r#"{"type":"control","owner":null}"#,
        ),
    ]
}

#[test]
fn every_message_looks_as_promised_and_reads_back() {
    for (message, json) in example_messages() {
        assert_eq!(serde_json::to_string(&message).unwrap(), json);
        assert_eq!(
            serde_json::from_str::<ServerMessage>(json).unwrap(),
            message
        );
    }
}

#[test]
fn the_pages_types_are_up_to_date() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(typescript::PATH);
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == typescript::module(),
        "{} is not what the types say; run `cargo run -p factotum-protocol --example codegen`",
        typescript::PATH
    );
}

#[test]
fn commands_are_exactly_these() {
    for (json, command) in [
        (r#"{"type":"pause"}"#, ClientMessage::Pause),
        (r#"{"type":"resume"}"#, ClientMessage::Resume),
        (r#"{"type":"stop"}"#, ClientMessage::Stop),
        (
            r#"{"type":"drive","forward":1.0,"left":-0.5,"turn":0.0}"#,
            ClientMessage::Drive(Drive {
                forward: 1.0,
                left: -0.5,
                turn: 0.0,
            }),
        ),
        (r#"{"type":"drive_done"}"#, ClientMessage::DriveDone),
    ] {
        assert_eq!(
            serde_json::from_str::<ClientMessage>(json).unwrap(),
            command
        );
        assert_eq!(serde_json::to_string(&command).unwrap(), json);
    }
    for refused in [
        "",
        "null",
        "{}",
        "[]",
        r#""pause""#,
        r#"{"type":"Pause"}"#,
        r#"{"type":"explode"}"#,
        r#"{"type":"pause""#,
        r#"{"type":"pause"}{"type":"stop"}"#,
    ] {
        assert!(
            serde_json::from_str::<ClientMessage>(refused).is_err(),
            "{refused}"
        );
    }
}

#[test]
fn a_velocity_that_no_hand_can_wish_is_refused_with_what_was_found_and_wanted() {
    let read = |fields: &str| {
        let json = format!(r#"{{"type":"drive",{fields}}}"#);
        serde_json::from_str::<ClientMessage>(&json).map_err(|error| error.to_string())
    };
    let whole = read(r#""forward":-1,"left":1,"turn":0"#);
    let wanted = Drive {
        forward: -1.0,
        left: 1.0,
        turn: 0.0,
    };
    assert_eq!(whole, Ok(ClientMessage::Drive(wanted)));
    for (fields, words) in [
        (
            r#""forward":1.01,"left":0,"turn":0"#,
            ["1.01", "in [-1, 1]"],
        ),
        (r#""forward":0,"left":-7,"turn":0"#, ["-7", "in [-1, 1]"]),
        (
            r#""forward":0,"left":0,"turn":1e300"#,
            ["1e+300", "in [-1, 1]"],
        ),
        (r#""forward":1e999,"left":0,"turn":0"#, ["number", "range"]),
        (r#""forward":NaN,"left":0,"turn":0"#, ["expected", "value"]),
        (r#""forward":null,"left":0,"turn":0"#, ["null", "f64"]),
        (r#""forward":"1","left":0,"turn":0"#, ["string", "f64"]),
        (r#""forward":0,"left":0"#, ["missing field", "turn"]),
        (
            r#""forward":0,"left":0,"turn":0,"up":1"#,
            ["unknown field", "up"],
        ),
    ] {
        let said = read(fields).unwrap_err();
        for word in words {
            assert!(said.contains(word), "no `{word}` in: {said}");
        }
    }
}

#[test]
fn a_state_with_a_number_that_is_not_finite_says_so() {
    let (ServerMessage::State(good), _) = example_messages().swap_remove(2) else {
        panic!("the third example is a state");
    };
    assert!(good.is_finite());
    let spoil: [fn(&mut State); 6] = [
        |state| state.time_secs = f64::NAN,
        |state| state.sim_speed = f64::INFINITY,
        |state| state.base.yaw = f64::NAN,
        |state| state.body_poses[0].pose.position[2] = f64::NAN,
        |state| state.body_poses[0].pose.orientation_xyzw[3] = f64::NEG_INFINITY,
        |state| state.joints[0].position = f64::NAN,
    ];
    for spoil in spoil {
        let mut spoilt = good.clone();
        spoil(&mut spoilt);
        assert!(!spoilt.is_finite(), "{spoilt:?}");
    }
}

fn map_of_runs(width: u32, height: u32, runs: &[i32]) -> OccupancyMap {
    OccupancyMap {
        width,
        height,
        resolution_m: 0.05,
        origin: ORIGIN,
        runs: runs.to_vec(),
    }
}

#[test]
fn malformed_maps_are_refused_by_name() {
    let count = |width, height, found, expected| MapError::CellCount {
        width,
        height,
        found,
        expected,
    };
    let cases = [
        (map_of_runs(2, 2, &[0, 3]), count(2, 2, 3, 4)),
        (map_of_runs(2, 2, &[0, 5]), count(2, 2, 5, 4)),
        (map_of_runs(2, 2, &[]), count(2, 2, 0, 4)),
        (
            map_of_runs(1, 1, &[0, i32::MAX]),
            count(1, 1, i32::MAX as u64, 1),
        ),
        (
            map_of_runs(2, 2, &[0, 2, 0]),
            MapError::RunCount { index: 1 },
        ),
        (
            map_of_runs(2, 2, &[0, 0, 0, 4]),
            MapError::RunCount { index: 0 },
        ),
        (
            map_of_runs(2, 2, &[0, 5, 0, -1]),
            MapError::RunCount { index: 1 },
        ),
        (
            map_of_runs(2, 2, &[101, 4]),
            MapError::CellValue {
                index: 0,
                found: 101,
            },
        ),
        (
            map_of_runs(2, 2, &[0, 1, -2, 3]),
            MapError::CellValue {
                index: 1,
                found: -2,
            },
        ),
    ];
    for (map, error) in cases {
        assert_eq!(map.cells(), Err(error), "{:?}", map.runs);
    }
    assert_eq!(map_of_runs(0, 7, &[]).cells(), Ok(Vec::new()));
    let refused = OccupancyMap::from_cells(2, 1, 0.05, ORIGIN, &[0, 101]);
    assert_eq!(
        refused,
        Err(MapError::CellValue {
            index: 1,
            found: 101
        })
    );
    let refused = OccupancyMap::from_cells(2, 2, 0.05, ORIGIN, &[0]);
    assert_eq!(refused, Err(count(2, 2, 1, 4)));
}

proptest! {
    #[test]
    fn maps_survive_the_wire(width in 0_u32..20, height in 0_u32..20, seed in any::<u64>()) {
        // Few values and a slow generator, so that there are runs of all lengths.
        let mut word = seed | 1;
        let cells: Vec<i8> = (0..width * height)
            .map(|_| {
                word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                [-1, 0, 0, 0, 0, 0, 37, 100][(word >> 61) as usize]
            })
            .collect();
        let map = OccupancyMap::from_cells(width, height, 0.05, ORIGIN, &cells).unwrap();
        let json = serde_json::to_string(&map).unwrap();
        let read: OccupancyMap = serde_json::from_str(&json).unwrap();
        prop_assert_eq!(read.cells().unwrap(), cells);
        let values: Vec<i32> = map.runs.chunks(2).map(|run| run[0]).collect();
        prop_assert!(values.windows(2).all(|pair| pair[0] != pair[1]), "runs are as long as can be");
    }

    #[test]
    fn a_yaw_becomes_a_unit_quaternion_of_that_yaw(yaw in -7.0_f64..7.0) {
        let [x, y, z, w] = Pose::from_position_yaw([0.0; 3], yaw).orientation_xyzw;
        prop_assert_eq!((x, y), (0.0, 0.0));
        prop_assert!((z * z + w * w - 1.0).abs() < 1e-12);
        let difference = 2.0 * z.atan2(w) - yaw;
        prop_assert!((difference / std::f64::consts::TAU).fract().abs().min(
            1.0 - (difference / std::f64::consts::TAU).fract().abs()) < 1e-9);
    }
}

#[test]
fn roles_rise_and_a_stop_is_for_everybody() {
    assert!(Role::ALL.is_sorted());
    for role in Role::ALL {
        assert_eq!(
            serde_json::to_string(&role).unwrap(),
            format!("{:?}", role.name())
        );
    }
    let edit = r#"{"type":"edit","id":"a","base":null,"edit":{"kind":"undo"}}"#;
    for (json, wanted) in [
        (r#"{"type":"stop"}"#, Role::View),
        (edit, Role::Teach),
        (r#"{"type":"pause"}"#, Role::Execute),
        (r#"{"type":"resume"}"#, Role::Execute),
        (
            r#"{"type":"drive","forward":0,"left":0,"turn":0}"#,
            Role::Execute,
        ),
        (r#"{"type":"drive_done"}"#, Role::Execute),
    ] {
        let message: ClientMessage = serde_json::from_str(json).unwrap();
        assert_eq!(message.role_needed(), wanted, "{json}");
    }
}
