//! Identifiers of a model's parts, one type per kind so that they cannot be mixed.
//!
//! An identifier is an index into one model; using it with another model is a bug of the caller and
//! panics when it is out of that model's range.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) usize);

        impl $name {
            /// Position among the model's parts of this kind, counted from zero.
            pub fn index(self) -> usize {
                self.0
            }
        }
    };
}

id!(
    /// A body. Body 0 is the world.
    BodyId
);
id!(
    /// A joint. Not a degree of freedom: see [`Model::dof_adr`](crate::Model::dof_adr).
    JointId
);
id!(
    /// A geom: a shape that collides, is seen, or both.
    GeomId
);
id!(
    /// A site: a named frame on a body.
    SiteId
);
id!(
    /// An actuator.
    ActuatorId
);
id!(
    /// A camera.
    CameraId
);
id!(
    /// A sensor.
    SensorId
);
id!(
    /// A keyframe: a stored state.
    KeyframeId
);

impl BodyId {
    /// The world body.
    pub const WORLD: Self = Self(0);
}
