//! Whatever a file holds, the answer is a model or an error.

use std::fs;

use factotum_physics::{Model, PhysicsError, State};
use proptest::prelude::*;

use crate::models::ARM_AND_BALL;

/// Compiles a text and, where that works, steps it.
fn load_and_step(xml: &str) -> Result<(), PhysicsError> {
    let model = Model::from_mjcf_str(xml)?;
    let mut state = State::new(&model)?;
    for _ in 0..20 {
        state.step()?;
    }
    state.forward()?;
    state.dynamics()
}

/// Cuts, repeats and overwrites pieces of a text.
fn mangled(text: &str, edits: &[(prop::sample::Index, prop::sample::Index, u8, String)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (at, len, kind, insert) in edits {
        if bytes.is_empty() {
            break;
        }
        let at = at.index(bytes.len());
        let end = (at + len.index(24)).min(bytes.len());
        match kind {
            0 => drop(bytes.drain(at..end)),
            1 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => drop(bytes.splice(at..end, insert.bytes())),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #[test]
    fn a_mangled_model_never_ends_the_process(
        edits in prop::collection::vec(
            (
                any::<prop::sample::Index>(),
                any::<prop::sample::Index>(),
                0_u8..3,
                "[-0-9.e \"'<>/=a-z]{0,6}|nan|inf|1e300|-1|0|mesh|hfield|sdf|free|\"\"",
            ),
            1..4,
        ),
    ) {
        // Either answer is right; that there is one is the point.
        drop(load_and_step(&mangled(ARM_AND_BALL, &edits)));
    }

    /// Sizes of every order.
    #[test]
    fn a_model_of_any_memory_never_ends_the_process(kilobytes in 0_u32..64) {
        let xml = ARM_AND_BALL.replace(
            "<worldbody>",
            &format!("<size memory=\"{kilobytes}K\"/><worldbody>"),
        );
        drop(load_and_step(&xml));
    }
}

/// Meshes are read on threads of MuJoCo's own.
#[test]
fn broken_meshes_are_errors() -> Result<(), Box<dyn std::error::Error>> {
    let dir = tempfile::tempdir()?;
    let mut lying_stl = vec![0_u8; 84];
    lying_stl[80..84].copy_from_slice(&1000_u32.to_le_bytes());
    let mut nan_stl = vec![0_u8; 84 + 50 * 4];
    nan_stl[80..84].copy_from_slice(&4_u32.to_le_bytes());
    nan_stl[84..].fill(0xff);
    let files: [(&str, Vec<u8>); 8] = [
        ("empty.stl", Vec::new()),
        ("empty.obj", Vec::new()),
        ("garbage.stl", b"solid nothing of the kind".to_vec()),
        ("lying.stl", lying_stl),
        ("nan.stl", nan_stl),
        (
            "flat.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n".to_vec(),
        ),
        (
            "far.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 99\nf 1 2 -99\n".to_vec(),
        ),
        ("text.obj", b"v a b c\nf x y z\n".to_vec()),
    ];
    let mut assets = String::new();
    for (i, (name, bytes)) in files.iter().enumerate() {
        fs::write(dir.path().join(name), bytes)?;
        let mesh = format!("<mesh name=\"m{i}\" file=\"{name}\"/>");
        let alone = dir.path().join(format!("model{i}.xml"));
        fs::write(
            &alone,
            format!(
                "<mujoco><asset>{mesh}</asset><worldbody><geom type=\"mesh\" mesh=\"m{i}\"/>\
                 </worldbody></mujoco>"
            ),
        )?;
        let error = Model::from_mjcf_file(&alone)
            .err()
            .map(|error| error.to_string());
        // A flat mesh is a mesh that MuJoCo may take; the others are not.
        if *name != "flat.obj" {
            let error = error.unwrap_or_else(|| panic!("{name} was taken"));
            assert!(error.contains(&format!("model{i}.xml")), "{name}: {error}");
        }
        assets.push_str(&mesh);
    }
    let all = dir.path().join("all.xml");
    fs::write(&all, format!("<mujoco><asset>{assets}</asset></mujoco>"))?;
    assert!(Model::from_mjcf_file(&all).is_err());
    Ok(())
}
