//! Cost of a step through this crate against MuJoCo's own, of the same models and states.
//!
//! `cargo bench -p factotum-physics`; the last line of each pair is MuJoCo alone. `ratio` prints
//! interleaved runs as one number, which a busy machine disturbs least.
#![expect(unsafe_code, reason = "raw mj_step is what is compared with")]
#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]

use std::path::Path;
use std::time::{Duration, Instant};

use divan::Bencher;
use factotum_physics::{Model, SceneBuilder, Shape, State};
use factotum_physics::{Motion, PhysicsError, Pose, Primitive};
use mujoco_rs::mujoco_c as raw;

/// Models by name: the smallest there is, an arm, boxes in contact, and the robosuite door if there.
const MODELS: [&str; 4] = ["pendulum", "chain", "boxes", "door"];

fn chain(n_links: usize) -> String {
    let mut body = String::new();
    for i in 0..n_links {
        let axis = if i % 2 == 0 { "0 1 0" } else { "0 0 1" };
        body.push_str(&format!(
            "<body pos='0 0 .2'><joint axis='{axis}' damping='.1'/>\
             <geom type='capsule' fromto='0 0 .05 0 0 .15' size='.03'/>"
        ));
    }
    body.push_str(&"</body>".repeat(n_links));
    format!("<mujoco><worldbody>{body}</worldbody></mujoco>")
}

fn boxes() -> Result<String, PhysicsError> {
    let mut scene = SceneBuilder::new();
    scene.add_floor("floor", [1.0; 4]);
    for i in 0..20_u8 {
        scene.add_shape(Shape {
            name: format!("box {i}"),
            primitive: Primitive::Box { half: [0.1; 3] },
            world_from_shape: Pose::translation(
                f64::from(i % 5) * 0.15,
                0.0,
                0.1 + f64::from(i / 5) * 0.2,
            ),
            rgba: [1.0; 4],
            collides: true,
            motion: Motion::Free { mass_kg: 1.0 },
        });
    }
    scene.xml()
}

/// The same model for both sides; `None` when its file is not there.
fn source(name: &str) -> Option<Source> {
    match name {
        "pendulum" => Some(Source::Text(chain(1))),
        "chain" => Some(Source::Text(chain(7))),
        "boxes" => boxes().ok().map(Source::Text),
        _ => {
            let file = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../../shared/data/robosuite_door/door.xml");
            file.is_file()
                .then(|| Source::File(file.display().to_string()))
        }
    }
}

enum Source {
    Text(String),
    File(String),
}

impl Source {
    fn state(&self) -> Result<State, PhysicsError> {
        let model = match self {
            Self::Text(xml) => Model::from_mjcf_str(xml)?,
            Self::File(path) => Model::from_mjcf_file(Path::new(path))?,
        };
        State::new(&model)
    }
}

/// MuJoCo's own model and data, with no wrapper.
struct Raw {
    model: *mut raw::mjModel,
    data: *mut raw::mjData,
}

impl Raw {
    fn new(source: &Source) -> Self {
        let mut error = [0; 512];
        let spec = match source {
            Source::Text(xml) => {
                let xml = std::ffi::CString::new(xml.as_str()).unwrap_or_default();
                // SAFETY: NUL-terminated text, an error buffer of its stated size.
                unsafe {
                    raw::mj_parseXMLString(xml.as_ptr(), std::ptr::null(), error.as_mut_ptr(), 512)
                }
            }
            Source::File(path) => {
                let path = std::ffi::CString::new(path.as_str()).unwrap_or_default();
                // SAFETY: NUL-terminated path, an error buffer of its stated size.
                unsafe {
                    raw::mj_parseXML(path.as_ptr(), std::ptr::null(), error.as_mut_ptr(), 512)
                }
            }
        };
        assert!(!spec.is_null(), "the model compiled before");
        // SAFETY: a live spec.
        let model = unsafe { raw::mj_compile(spec, std::ptr::null()) };
        // SAFETY: a live spec, not used again.
        unsafe { raw::mj_deleteSpec(spec) };
        assert!(!model.is_null(), "the model compiled before");
        // SAFETY: a live model.
        let data = unsafe { raw::mj_makeData(model) };
        Self { model, data }
    }

    fn step(&mut self) {
        // SAFETY: a live model and its data.
        unsafe { raw::mj_step(self.model, self.data) };
    }

    fn reset(&mut self) {
        // SAFETY: a live model and its data.
        unsafe { raw::mj_resetData(self.model, self.data) };
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // SAFETY: owned here, not used again.
        unsafe { raw::mj_deleteData(self.data) };
        // SAFETY: as above.
        unsafe { raw::mj_deleteModel(self.model) };
    }
}

/// Steps from the start, so that both sides do the same work.
const N_STEPS: usize = 200;

#[divan::bench(args = MODELS)]
fn ours(bencher: Bencher<'_, '_>, name: &str) {
    let Some(mut state) = source(name).and_then(|source| source.state().ok()) else {
        return;
    };
    bencher.bench_local(|| {
        state.reset().expect("sound");
        for _ in 0..N_STEPS {
            state.step().expect("sound");
        }
    });
}

#[divan::bench(args = MODELS)]
fn mujoco(bencher: Bencher<'_, '_>, name: &str) {
    let Some(mut raw) = source(name).map(|source| Raw::new(&source)) else {
        return;
    };
    bencher.bench_local(|| {
        raw.reset();
        for _ in 0..N_STEPS {
            raw.step();
        }
    });
}

/// Median time of a run of each side, runs taken in turn.
fn ratio(source: &Source) -> Option<(Duration, Duration)> {
    const N_RUNS: usize = 41;
    let mut state = source.state().ok()?;
    let mut raw = Raw::new(source);
    let (mut ours, mut mujoco) = (Vec::new(), Vec::new());
    for _ in 0..N_RUNS {
        let start = Instant::now();
        state.reset().ok()?;
        for _ in 0..N_STEPS {
            state.step().ok()?;
        }
        ours.push(start.elapsed());
        let start = Instant::now();
        raw.reset();
        for _ in 0..N_STEPS {
            raw.step();
        }
        mujoco.push(start.elapsed());
    }
    ours.sort_unstable();
    mujoco.sort_unstable();
    Some((ours[N_RUNS / 2], mujoco[N_RUNS / 2]))
}

fn main() {
    for name in MODELS {
        if let Some((ours, mujoco)) = source(name).and_then(|source| ratio(&source)) {
            println!(
                "ratio {name}: {:.3} ({:.2} µs against {:.2} µs a step)",
                ours.as_secs_f64() / mujoco.as_secs_f64(),
                ours.as_secs_f64() / N_STEPS as f64 * 1e6,
                mujoco.as_secs_f64() / N_STEPS as f64 * 1e6
            );
        }
    }
    divan::main();
}
