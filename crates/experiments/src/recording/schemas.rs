//! JSON schemas of the recorded messages: the field names and types that Foxglove asks for, as far as we fill them.

use serde_json::{Map, Value, json};

/// The schema of this name; one that is not Foxglove's allows any object.
pub(super) fn of(name: &str) -> Value {
    let properties = match name {
        "foxglove.FrameTransforms" => object(&[("transforms", list(frame_transform()))]),
        "foxglove.SceneUpdate" => object(&[
            ("deletions", list(scene_entity_deletion())),
            ("entities", list(scene_entity())),
        ]),
        "foxglove.Grid" => object(&[
            ("timestamp", time()),
            ("frame_id", string()),
            ("pose", pose()),
            ("column_count", integer()),
            ("cell_size", object(&[("x", number()), ("y", number())])),
            ("row_stride", integer()),
            ("cell_stride", integer()),
            (
                "fields",
                list(object(&[
                    ("name", string()),
                    ("offset", integer()),
                    ("type", integer()),
                ])),
            ),
            (
                "data",
                json!({"type": "string", "contentEncoding": "base64"}),
            ),
        ]),
        "foxglove.LaserScan" => object(&[
            ("timestamp", time()),
            ("frame_id", string()),
            ("pose", pose()),
            ("start_angle", number()),
            ("end_angle", number()),
            ("ranges", list(number())),
            ("intensities", list(number())),
        ]),
        "foxglove.Log" => object(&[
            ("timestamp", time()),
            ("level", integer()),
            ("message", string()),
            ("name", string()),
            ("file", string()),
            ("line", integer()),
        ]),
        _ => json!({"type": "object"}),
    };
    let mut schema = properties;
    schema["title"] = json!(name);
    schema
}

fn frame_transform() -> Value {
    object(&[
        ("timestamp", time()),
        ("parent_frame_id", string()),
        ("child_frame_id", string()),
        ("translation", vector()),
        ("rotation", quaternion()),
    ])
}

fn scene_entity_deletion() -> Value {
    object(&[("timestamp", time()), ("type", integer()), ("id", string())])
}

fn scene_entity() -> Value {
    object(&[
        ("timestamp", time()),
        ("frame_id", string()),
        ("id", string()),
        ("lifetime", time()),
        ("frame_locked", json!({"type": "boolean"})),
        (
            "metadata",
            list(object(&[("key", string()), ("value", string())])),
        ),
        (
            "arrows",
            list(object(&[
                ("pose", pose()),
                ("shaft_length", number()),
                ("shaft_diameter", number()),
                ("head_length", number()),
                ("head_diameter", number()),
                ("color", color()),
            ])),
        ),
        (
            "cubes",
            list(object(&[
                ("pose", pose()),
                ("size", vector()),
                ("color", color()),
            ])),
        ),
        (
            "spheres",
            list(object(&[
                ("pose", pose()),
                ("size", vector()),
                ("color", color()),
            ])),
        ),
        (
            "cylinders",
            list(object(&[
                ("pose", pose()),
                ("size", vector()),
                ("bottom_scale", number()),
                ("top_scale", number()),
                ("color", color()),
            ])),
        ),
        (
            "lines",
            list(object(&[
                ("type", integer()),
                ("pose", pose()),
                ("thickness", number()),
                ("scale_invariant", json!({"type": "boolean"})),
                ("points", list(vector())),
                ("color", color()),
                ("colors", list(color())),
                ("indices", list(integer())),
            ])),
        ),
        (
            "triangles",
            list(object(&[
                ("pose", pose()),
                ("points", list(vector())),
                ("color", color()),
                ("colors", list(color())),
                ("indices", list(integer())),
            ])),
        ),
        (
            "texts",
            list(object(&[
                ("pose", pose()),
                ("billboard", json!({"type": "boolean"})),
                ("font_size", number()),
                ("scale_invariant", json!({"type": "boolean"})),
                ("color", color()),
                ("text", string()),
            ])),
        ),
        ("models", list(json!({"type": "object"}))),
    ])
}

fn object(fields: &[(&str, Value)]) -> Value {
    let properties: Map<String, Value> = fields
        .iter()
        .map(|(name, schema)| ((*name).to_owned(), schema.clone()))
        .collect();
    let required: Vec<&str> = fields.iter().map(|(name, _)| *name).collect();
    json!({"type": "object", "properties": properties, "required": required})
}

fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

fn number() -> Value {
    json!({"type": "number"})
}

fn integer() -> Value {
    json!({"type": "integer"})
}

fn string() -> Value {
    json!({"type": "string"})
}

fn time() -> Value {
    object(&[("sec", integer()), ("nsec", integer())])
}

fn vector() -> Value {
    object(&[("x", number()), ("y", number()), ("z", number())])
}

fn quaternion() -> Value {
    object(&[
        ("x", number()),
        ("y", number()),
        ("z", number()),
        ("w", number()),
    ])
}

fn pose() -> Value {
    object(&[("position", vector()), ("orientation", quaternion())])
}

fn color() -> Value {
    object(&[
        ("r", number()),
        ("g", number()),
        ("b", number()),
        ("a", number()),
    ])
}
