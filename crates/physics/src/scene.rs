//! Composition: a world of primitive shapes, to which parts from other files are attached unchanged.
//!
//! The world is a text of ours; parts are read by MuJoCo from their own files, so that their assets,
//! defaults and compiler settings stay their own, and attached with their names prefixed. Options of a
//! part (time step, cone and so on) yield to the scene's. Nothing is built until
//! [`SceneBuilder::compile`].

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use mujoco_rs::mujoco_c::mjtObj;

use crate::Pose;
use crate::axes::wxyz_from_quat;
use crate::error::PhysicsError;
use crate::model::Model;
use crate::spec::{NewActuator, Spec};
use crate::urdf::{UrdfOptions, urdf_spec};

/// A model file to attach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// MJCF, or URDF (by its extension).
    pub file: PathBuf,
    /// What its names begin with in the scene; an attached name is `prefix + name`.
    pub prefix: String,
}

/// Where a part is attached.
#[derive(Debug, Clone, PartialEq)]
pub enum AttachPoint {
    /// At a pose in the world.
    World(Pose),
    /// At a pose in the frame of a site, or else of a body, of a part attached before.
    Frame {
        /// Name of the site or body, with its prefix.
        name: String,
        /// Pose of the part's root in that frame.
        offset: Pose,
    },
}

/// What a part has, by its own names (before the prefix).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PartNames {
    /// Bodies.
    pub bodies: Vec<String>,
    /// Joints.
    pub joints: Vec<String>,
    /// Sites.
    pub sites: Vec<String>,
    /// Actuators.
    pub actuators: Vec<String>,
}

impl PartNames {
    /// Reads a model file without compiling it.
    ///
    /// # Errors
    /// As [`SceneBuilder::attach`].
    pub fn read(file: &Path, urdf: &UrdfOptions) -> Result<Self, PhysicsError> {
        let spec = read_spec(file, urdf)?;
        Ok(Self {
            bodies: spec.names(mjtObj::mjOBJ_BODY),
            joints: spec.names(mjtObj::mjOBJ_JOINT),
            sites: spec.names(mjtObj::mjOBJ_SITE),
            actuators: spec.names(mjtObj::mjOBJ_ACTUATOR),
        })
    }
}

/// What else to do to a part.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AttachOptions {
    /// Whether its root bodies get free joints, named `prefix + body + "_free"`.
    pub free: bool,
    /// Actuators to add; names and joints before the prefix.
    pub actuators: Vec<NewActuator>,
    /// Sites to add: name, body, and pose in the body; names before the prefix.
    pub sites: Vec<NewSite>,
    /// How a URDF is read.
    pub urdf: UrdfOptions,
}

/// A site to add to a part.
#[derive(Debug, Clone, PartialEq)]
pub struct NewSite {
    /// Its name, before the prefix.
    pub name: String,
    /// The body it is fixed to, before the prefix.
    pub body: String,
    /// Its pose in the body.
    pub body_from_site: Pose,
}

/// A primitive shape; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// A box.
    Box {
        /// Half extents.
        half: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        r: f64,
        /// Half its length.
        half: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius.
        r: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius.
        r: f64,
        /// Half the length of its cylindrical part.
        half: f64,
    },
    /// The plane z = 0, solid below.
    Plane {
        /// Half extents to draw.
        half: [f64; 2],
    },
}

/// How a shape may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// By hand, with [`State::set_mocap`](crate::State::set_mocap).
    Mocap,
    /// Freely, with a mass in kg.
    Free {
        /// Mass, kg.
        mass_kg: f64,
    },
}

/// A body of one primitive geom; both have its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Name of body and geom.
    pub name: String,
    /// The shape.
    pub primitive: Primitive,
    /// Its pose.
    pub world_from_shape: Pose,
    /// Its colour.
    pub rgba: [f32; 4],
    /// Whether it collides.
    pub collides: bool,
    /// How it may move.
    pub motion: Motion,
}

/// How a step integrates velocities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Semi-implicit Euler, implicit in joint damping only.
    Euler,
    /// Implicit in joint damping and in the gains of servos, but not in Coriolis forces: stiff servos
    /// on light bodies stay stable.
    ImplicitFast,
    /// Fourth-order Runge-Kutta; four times the cost, and no [`State::step1`](crate::State::step1).
    RungeKutta,
}

/// Physics options of a scene; the defaults are MuJoCo's but for the cone and its impedance ratio,
/// which are what grasps need to hold, and the integrator, which stiff servos need.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneOptions {
    /// Length of a step, s.
    pub timestep_secs: f64,
    /// How velocities are integrated.
    pub integrator: Integrator,
    /// Whether friction cones are elliptic.
    pub elliptic_cone: bool,
    /// Ratio of friction to normal impedance of elliptic cones.
    pub impratio: f64,
    /// Gravity in the world, m/s².
    pub gravity: [f64; 3],
    /// Memory of a state for contacts and scratch, as `"64M"`; `None` leaves it to MuJoCo.
    pub memory: Option<String>,
    /// Whether geoms that only draw, and their meshes, are compiled. Masses are the same without.
    pub visuals: bool,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            timestep_secs: 0.002,
            integrator: Integrator::ImplicitFast,
            elliptic_cone: true,
            impratio: 10.0,
            gravity: [0.0, 0.0, -9.81],
            memory: None,
            visuals: true,
        }
    }
}

#[derive(Debug, Clone)]
struct Attachment {
    source: Source,
    prefix: String,
    at: AttachPoint,
    options: AttachOptions,
}

#[derive(Debug, Clone)]
enum Source {
    File(PathBuf),
    Text { origin: String, xml: String },
}

/// Builds a scene; see the [module](self).
#[derive(Debug, Clone)]
pub struct SceneBuilder {
    name: String,
    options: SceneOptions,
    shapes: Vec<Shape>,
    attachments: Vec<Attachment>,
    excludes: Vec<(String, String)>,
}

impl Default for SceneBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl SceneBuilder {
    /// An empty scene.
    pub fn new() -> Self {
        Self {
            name: "scene".to_owned(),
            options: SceneOptions::default(),
            shapes: Vec::new(),
            attachments: Vec::new(),
            excludes: Vec::new(),
        }
    }

    /// Names the scene's model.
    pub fn name(&mut self, name: &str) -> &mut Self {
        name.clone_into(&mut self.name);
        self
    }

    /// Sets all physics options.
    pub fn options(&mut self, options: SceneOptions) -> &mut Self {
        self.options = options;
        self
    }

    /// Sets the length of a step, s.
    pub fn timestep_secs(&mut self, timestep_secs: f64) -> &mut Self {
        self.options.timestep_secs = timestep_secs;
        self
    }

    /// Sets the ratio of friction to normal impedance.
    pub fn impratio(&mut self, impratio: f64) -> &mut Self {
        self.options.impratio = impratio;
        self
    }

    /// Attaches a part, with free joints on its root bodies if `free`. The file is read now, so that
    /// a broken one is found here; it is read again by [`compile`](Self::compile).
    ///
    /// # Errors
    /// [`PhysicsError::File`], [`PhysicsError::Parse`]; for a URDF also what
    /// [`urdf_to_mjcf`](crate::urdf_to_mjcf) says.
    pub fn attach(
        &mut self,
        part: &Part,
        at: &AttachPoint,
        free: bool,
    ) -> Result<(), PhysicsError> {
        self.attach_with(
            part,
            at,
            &AttachOptions {
                free,
                ..AttachOptions::default()
            },
        )
    }

    /// Attaches a part with more options, as [`attach`](Self::attach).
    ///
    /// # Errors
    /// As [`attach`](Self::attach).
    pub fn attach_with(
        &mut self,
        part: &Part,
        at: &AttachPoint,
        options: &AttachOptions,
    ) -> Result<(), PhysicsError> {
        self.push(Source::File(part.file.clone()), &part.prefix, at, options)
    }

    /// Attaches a part given as MJCF text; `origin` says what it is, for messages.
    ///
    /// # Errors
    /// As [`attach`](Self::attach).
    pub fn attach_text(
        &mut self,
        origin: &str,
        xml: &str,
        prefix: &str,
        at: &AttachPoint,
        options: &AttachOptions,
    ) -> Result<(), PhysicsError> {
        let source = Source::Text {
            origin: origin.to_owned(),
            xml: xml.to_owned(),
        };
        self.push(source, prefix, at, options)
    }

    fn push(
        &mut self,
        source: Source,
        prefix: &str,
        at: &AttachPoint,
        options: &AttachOptions,
    ) -> Result<(), PhysicsError> {
        let attachment = Attachment {
            source,
            prefix: prefix.to_owned(),
            at: at.clone(),
            options: options.clone(),
        };
        attachment.read()?;
        self.attachments.push(attachment);
        Ok(())
    }

    /// Adds a shape.
    pub fn add_shape(&mut self, shape: Shape) -> &mut Self {
        self.shapes.push(shape);
        self
    }

    /// Adds a fixed box with these half extents.
    pub fn add_box(
        &mut self,
        name: &str,
        world_from_box: &Pose,
        half: [f64; 3],
        rgba: [f32; 4],
        collide: bool,
    ) -> &mut Self {
        self.add_fixed(name, world_from_box, Primitive::Box { half }, rgba, collide)
    }

    /// Adds a fixed cylinder along z; `size` is radius and half length.
    pub fn add_cylinder(
        &mut self,
        name: &str,
        world_from_cylinder: &Pose,
        size: [f64; 2],
        rgba: [f32; 4],
        collide: bool,
    ) -> &mut Self {
        let [r, half] = size;
        self.add_fixed(
            name,
            world_from_cylinder,
            Primitive::Cylinder { r, half },
            rgba,
            collide,
        )
    }

    /// Adds a fixed sphere.
    pub fn add_sphere(
        &mut self,
        name: &str,
        world_from_sphere: &Pose,
        radius_m: f64,
        rgba: [f32; 4],
        collide: bool,
    ) -> &mut Self {
        self.add_fixed(
            name,
            world_from_sphere,
            Primitive::Sphere { r: radius_m },
            rgba,
            collide,
        )
    }

    /// Adds a floor, the plane z = 0.
    pub fn add_floor(&mut self, name: &str, rgba: [f32; 4]) -> &mut Self {
        let half = [0.0, 0.0]; // endless
        self.add_fixed(
            name,
            &Pose::identity(),
            Primitive::Plane { half },
            rgba,
            true,
        )
    }

    fn add_fixed(
        &mut self,
        name: &str,
        pose: &Pose,
        primitive: Primitive,
        rgba: [f32; 4],
        collides: bool,
    ) -> &mut Self {
        self.add_shape(Shape {
            name: name.to_owned(),
            primitive,
            world_from_shape: *pose,
            rgba,
            collides,
            motion: Motion::Fixed,
        })
    }

    /// Sets whether geoms that only draw are compiled.
    pub fn visuals(&mut self, visuals: bool) -> &mut Self {
        self.options.visuals = visuals;
        self
    }

    /// Takes contacts between two bodies (names with prefix) out of collision detection.
    pub fn exclude_contacts(&mut self, body_a: &str, body_b: &str) -> &mut Self {
        self.excludes.push((body_a.to_owned(), body_b.to_owned()));
        self
    }

    /// The world's own text, without the attached parts.
    pub fn world_xml(&self) -> String {
        let mut xml = String::new();
        self.write_world(&mut xml).ok(); // writing to a String cannot fail
        xml
    }

    fn write_world(&self, xml: &mut String) -> std::fmt::Result {
        let o = &self.options;
        let [gx, gy, gz] = o.gravity;
        let cone = if o.elliptic_cone {
            "elliptic"
        } else {
            "pyramidal"
        };
        let integrator = match o.integrator {
            Integrator::Euler => "Euler",
            Integrator::ImplicitFast => "implicitfast",
            Integrator::RungeKutta => "RK4",
        };
        writeln!(xml, "<mujoco model=\"{}\">", escaped(&self.name))?;
        writeln!(
            xml,
            "  <compiler angle=\"radian\" discardvisual=\"{}\"/>",
            !o.visuals
        )?;
        writeln!(
            xml,
            "  <option timestep=\"{}\" integrator=\"{integrator}\" cone=\"{cone}\" impratio=\"{}\" gravity=\"{gx} {gy} {gz}\"/>",
            o.timestep_secs, o.impratio
        )?;
        if let Some(memory) = &o.memory {
            writeln!(xml, "  <size memory=\"{}\"/>", escaped(memory))?;
        }
        writeln!(xml, "  <worldbody>")?;
        for shape in &self.shapes {
            shape.write(xml)?;
        }
        writeln!(xml, "  </worldbody>")?;
        writeln!(xml, "</mujoco>")
    }

    fn build(&self) -> Result<Spec, PhysicsError> {
        let mut scene = Spec::from_text(&self.name, &self.world_xml())?;
        for attachment in &self.attachments {
            let part = attachment.read()?;
            let (frame, offset) = match &attachment.at {
                AttachPoint::World(pose) => (None, pose),
                AttachPoint::Frame { name, offset } => (Some(name.as_str()), offset),
            };
            scene.attach(frame, part, offset, &attachment.prefix)?;
        }
        for (a, b) in &self.excludes {
            scene.add_exclude(a, b)?;
        }
        Ok(scene)
    }

    /// The whole scene as MJCF, for people to read.
    ///
    /// # Errors
    /// As [`compile`](Self::compile).
    pub fn xml(&self) -> Result<String, PhysicsError> {
        let mut scene = self.build()?;
        scene.compile()?;
        scene.to_xml()
    }

    /// Reads all parts, puts them together and compiles.
    ///
    /// # Errors
    /// [`PhysicsError::Attach`], [`PhysicsError::Compile`] with MuJoCo's words, as for two parts with
    /// the same names; [`PhysicsError::UnknownName`] for a site that no earlier part has.
    pub fn compile(&self) -> Result<Model, PhysicsError> {
        self.build()?.compile()
    }
}

impl Attachment {
    fn read(&self) -> Result<Spec, PhysicsError> {
        let mut part = match &self.source {
            Source::File(file) => read_spec(file, &self.options.urdf)?,
            Source::Text { origin, xml } => Spec::from_text(origin, xml)?,
        };
        for site in &self.options.sites {
            part.add_site(&site.body, &site.name, &site.body_from_site)?;
        }
        for actuator in &self.options.actuators {
            part.add_actuator(actuator)?;
        }
        if self.options.free {
            part.free_roots()?;
        }
        Ok(part)
    }
}

fn read_spec(file: &Path, urdf: &UrdfOptions) -> Result<Spec, PhysicsError> {
    let is_urdf = file
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"));
    if is_urdf {
        urdf_spec(file, urdf)
    } else {
        Spec::from_file(file)
    }
}

impl Shape {
    fn write(&self, xml: &mut String) -> std::fmt::Result {
        let name = escaped(&self.name);
        let p = self.world_from_shape.translation.vector;
        let [w, x, y, z] = wxyz_from_quat(&self.world_from_shape.rotation);
        let (kind, size) = match self.primitive {
            Primitive::Box { half: [a, b, c] } => ("box", format!("{a} {b} {c}")),
            Primitive::Cylinder { r, half } => ("cylinder", format!("{r} {half}")),
            Primitive::Sphere { r } => ("sphere", format!("{r}")),
            Primitive::Capsule { r, half } => ("capsule", format!("{r} {half}")),
            // The third size is the spacing of the drawn grid.
            Primitive::Plane { half: [a, b] } => ("plane", format!("{a} {b} 1")),
        };
        let bits = if self.collides {
            ""
        } else {
            " contype=\"0\" conaffinity=\"0\""
        };
        let mass = match self.motion {
            Motion::Free { mass_kg } => format!(" mass=\"{mass_kg}\""),
            Motion::Fixed | Motion::Mocap => String::new(),
        };
        let mocap = if self.motion == Motion::Mocap {
            " mocap=\"true\""
        } else {
            ""
        };
        writeln!(
            xml,
            "    <body name=\"{name}\" pos=\"{} {} {}\" quat=\"{w} {x} {y} {z}\"{mocap}>",
            p.x, p.y, p.z
        )?;
        if matches!(self.motion, Motion::Free { .. }) {
            writeln!(xml, "      <freejoint name=\"{name}_free\"/>")?;
        }
        let [r, g, b, a] = self.rgba;
        writeln!(
            xml,
            "      <geom name=\"{name}\" type=\"{kind}\" size=\"{size}\" rgba=\"{r} {g} {b} {a}\"{mass}{bits}/>"
        )?;
        writeln!(xml, "    </body>")
    }
}

/// A text for an XML attribute.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\n' | '\r' | '\t' => {
                out.push_str(&format!("&#{};", u32::from(c)));
            }
            c => out.push(c),
        }
    }
    out
}
