//! What the wire promises of edits: their shape, and refusal of what is none.

use factotum_protocol::{
    Action, ActionMotion, Approach, ClientMessage, Contact, Edit, EditAnswer, EditOutcome,
    EditRequest, Form, Grasp, Pose, Provenance, ServerMessage,
};
use proptest::prelude::*;

fn request(edit: Edit) -> ClientMessage {
    ClientMessage::Edit(Box::new(EditRequest {
        id: "5eed".to_owned(),
        base: Some(7),
        edit,
    }))
}

fn examples() -> Vec<(Edit, &'static str)> {
    let (flask, side) = (|| "flask".to_owned(), || "side".to_owned());
    vec![
        (
            Edit::MakeClass {
                name: flask(),
                form: Form::Cylinder {
                    diameter_m: 0.065,
                    height_m: 0.2,
                },
                movable: true,
            },
            r#"{"kind":"make_class","name":"flask","form":{"kind":"cylinder","diameter_m":0.065,"height_m":0.2},"movable":true}"#,
        ),
        (
            Edit::PutGrasp {
                class: flask(),
                grasp: Grasp {
                    name: side(),
                    object_from_tool: Pose::IDENTITY,
                    aperture_m: 0.1,
                    link: None,
                    yaw_symmetric: true,
                    provenance: Provenance::Taught,
                },
            },
            r#"{"kind":"put_grasp","class":"flask","grasp":{"name":"side","object_from_tool":{"position":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]},"aperture_m":0.1,"link":null,"yaw_symmetric":true,"provenance":"taught"}}"#,
        ),
        (
            Edit::PutAction {
                class: "faucet".to_owned(),
                action: Action {
                    name: "close".to_owned(),
                    grasp: Some(side()),
                    motion: ActionMotion::Joint {
                        joint: "handle".to_owned(),
                        initiation: Some(1.2),
                        termination: 0.0,
                        contact: Contact::Push,
                        effect: "closed".to_owned(),
                    },
                    approach: Some(Approach {
                        distance_m: [0.8, 1.25],
                    }),
                    provenance: Provenance::Taught,
                },
            },
            r#"{"kind":"put_action","class":"faucet","action":{"name":"close","grasp":"side","motion":{"kind":"joint","joint":"handle","initiation":1.2,"termination":0.0,"contact":"push","effect":"closed"},"approach":{"distance_m":[0.8,1.25]},"provenance":"taught"}}"#,
        ),
        (
            Edit::AddObject {
                class: flask(),
                pose: Pose::IDENTITY,
            },
            r#"{"kind":"add_object","class":"flask","pose":{"position":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]}}"#,
        ),
        (
            Edit::RemoveGrasp {
                class: flask(),
                name: side(),
            },
            r#"{"kind":"remove_grasp","class":"flask","name":"side"}"#,
        ),
        (Edit::Undo, r#"{"kind":"undo"}"#),
    ]
}

fn text_of(edit: &str) -> String {
    format!(r#"{{"type":"edit","id":"5eed","base":7,"edit":{edit}}}"#)
}

#[test]
fn every_edit_looks_as_promised_and_reads_back() {
    for (edit, json) in examples() {
        let message = request(edit);
        let text = text_of(json);
        assert_eq!(serde_json::to_string(&message).unwrap(), text);
        assert_eq!(
            serde_json::from_str::<ClientMessage>(&text).unwrap(),
            message
        );
    }
}

#[test]
fn answers_look_as_promised() {
    let answer = |outcome| {
        serde_json::to_string(&ServerMessage::EditAnswer(EditAnswer {
            id: "5eed".to_owned(),
            outcome,
        }))
        .unwrap()
    };
    assert_eq!(
        answer(EditOutcome::Accepted {
            entry: Some(8),
            what: "flask_1".to_owned()
        }),
        r#"{"type":"edit_answer","id":"5eed","outcome":{"kind":"accepted","entry":8,"what":"flask_1"}}"#
    );
    assert_eq!(
        answer(EditOutcome::Refused {
            reason: "why".to_owned()
        }),
        r#"{"type":"edit_answer","id":"5eed","outcome":{"kind":"refused","reason":"why"}}"#
    );
}

#[test]
fn a_number_that_is_not_finite_is_found_wherever_it_is() {
    let broken = Pose {
        position: [0.0, f64::NAN, 0.0],
        ..Pose::IDENTITY
    };
    for (edit, _) in examples() {
        assert!(edit.is_finite());
        let edit = match edit {
            Edit::AddObject { class, .. } => Edit::AddObject {
                class,
                pose: broken,
            },
            Edit::PutGrasp { class, grasp } => Edit::PutGrasp {
                class,
                grasp: Grasp {
                    object_from_tool: broken,
                    ..grasp
                },
            },
            Edit::PutAction { class, action } => Edit::PutAction {
                class,
                action: Action {
                    approach: Some(Approach {
                        distance_m: [0.8, f64::INFINITY],
                    }),
                    ..action
                },
            },
            Edit::MakeClass { name, movable, .. } => Edit::MakeClass {
                name,
                form: Form::Box {
                    size_m: [f64::NAN; 3],
                },
                movable,
            },
            _ => continue,
        };
        assert!(!edit.is_finite(), "{edit:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A byte replaced, taken out or put in: the message is refused, or it is another good one.
    #[test]
    fn a_damaged_edit_is_refused_or_is_another(
        which in 0_usize..6,
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        kind in 0..3,
    ) {
        let mut bytes = text_of(examples()[which].1).into_bytes();
        let at = at.index(bytes.len());
        match kind {
            0 => bytes[at] = byte,
            1 => { bytes.remove(at); }
            _ => bytes.insert(at, byte),
        }
        if let Ok(ClientMessage::Edit(request)) = serde_json::from_slice(&bytes) {
            prop_assert!(request.edit.is_finite());
            let again = serde_json::to_string(&ClientMessage::Edit(request.clone())).unwrap();
            prop_assert_eq!(serde_json::from_str::<ClientMessage>(&again).unwrap(), ClientMessage::Edit(request));
        }
    }
}
