//! Effects: what an action was to bring about, and what a look says of it.

use std::collections::BTreeSet;

use factotum_descriptions::ActionSpec;
use factotum_geometry::Pose;
use factotum_geometry::frames::pose_from_planar;
use factotum_semantic_map::Location;
use factotum_skills::{Failure, is_holding};
use nalgebra::Point3;

use crate::perform::is_gone;
use crate::senses::Care;
use crate::{AgentError, Executive};

/// How far outside the interval of a state a joint may be read and still count, as a share of the interval.
const EFFECT_MARGIN: f64 = 0.5;

/// Standard deviation to which the position of an object is doubted before it is looked at closely, metres.
const DOUBTED_STD_M: f64 = 0.1;

/// Standard deviation of the position of an object that was let go and not seen since, metres.
const LOST_STD_M: f64 = 0.3;

/// Standard deviation of the position of an object that may be anywhere, metres.
const ANYWHERE_STD_M: f64 = 10.0;

/// An effect that was looked for: there, or why it is not.
type Effect = Result<(), String>;

impl Executive<'_> {
    /// Looks closely at an object that is to be acted on; the answer is what about it is not as it was known before the
    /// robot came near, if something is not.
    ///
    /// What was seen of it from elsewhere carries the error of having been elsewhere: now that the arm depends on it, the
    /// new pictures alone say where it is.
    pub(crate) fn look_for(&mut self, name: &str, known_at: &Pose) -> Result<Effect, AgentError> {
        /// An object seen this far from where it was known to be has been moved, metres.
        const MOVED_M: f64 = 0.08;
        let gone = || Ok(Err(is_gone(name)));
        // That it is gone may have been seen on the way already.
        let Some(object) = self.aosm.objects.get_mut(name) else {
            return gone();
        };
        let known_std_m = object.position_std_m;
        object.position_std_m = DOUBTED_STD_M;
        self.senses.doubt(name, DOUBTED_STD_M);
        self.look_closely()?;
        let Some(object) = self.aosm.objects.get_mut(name) else {
            return gone();
        };
        if object.position_std_m >= DOUBTED_STD_M {
            // It was out of view.
            object.position_std_m = known_std_m;
        }
        let moved = object.map_from_object.translation.vector - known_at.translation.vector;
        if moved.norm() > MOVED_M {
            return Ok(Err(format!("`{name}` was moved by {:.2} m", moved.norm())));
        }
        Ok(Ok(()))
    }

    /// Whether a joint is where an action was to bring it, by a look.
    pub(crate) fn check_turned(
        &mut self,
        name: &str,
        action: &ActionSpec,
    ) -> Result<Effect, AgentError> {
        self.look_at_rest(Care::Joints)?;
        let object = self.aosm.object(name)?;
        let class = self.aosm.class(&object.class)?;
        let effect = action.effect.as_deref();
        let Some(expected) = effect.and_then(|effect| class.state(effect)) else {
            return Ok(Ok(()));
        };
        let [state, joint] = [&expected.name, &expected.joint];
        let Some(position) = object.joints.get(joint) else {
            return Ok(Err(format!("the {joint} of `{name}` cannot be seen")));
        };
        // A joint pushed against its stop is believed a little beyond it.
        let [lower, upper] = expected.range;
        let margin = EFFECT_MARGIN * (upper - lower);
        if (lower - margin..=upper + margin).contains(position) {
            return Ok(Ok(()));
        }
        Ok(Err(format!(
            "`{name}` is not {state}: its {joint} is at {position:.2}"
        )))
    }

    /// Whether an object that was let go is in its target, by a look: it is believed to be there unless it is seen
    /// elsewhere.
    pub(crate) fn check_placed(&mut self, name: &str, target: &str) -> Result<Effect, AgentError> {
        let map_from_target = self.aosm.object(target)?.map_from_object;
        self.seek(name, &map_from_target, Self::look_closely)?;
        let map_from_object = self.aosm.object(name)?.map_from_object;
        if self.is_within(target, &map_from_object)? {
            self.aosm.object_mut(name)?.location = Location::In(target.to_owned());
            return Ok(Ok(()));
        }
        Ok(Err(format!("`{name}` is seen outside `{target}`")))
    }

    /// Looks for an object that was let go, by intent or not: what turns up near where it is believed to be, or
    /// was not known before, is taken for it. Without a sighting it is left loose where it is believed to be. Tells
    /// whether it was seen.
    fn seek(
        &mut self,
        name: &str,
        believed_at: &Pose,
        look: impl FnOnce(&mut Self) -> Result<(), AgentError>,
    ) -> Result<bool, AgentError> {
        let mut object = self.aosm.object(name)?.clone();
        object.location = Location::Loose;
        object.map_from_object = *believed_at;
        object.position_std_m = ANYWHERE_STD_M;
        self.aosm.objects.insert(name.to_owned(), object.clone());
        self.senses.forget(name);
        let names = |this: &Self| -> BTreeSet<String> {
            let objects = this.aosm.objects_of(&object.class);
            objects.map(|object| object.name.clone()).collect()
        };
        let known = names(self);
        look(self)?;
        let mut sighting = self.aosm.objects.get(name).cloned();
        for stranger in names(self).difference(&known) {
            self.senses.rename(stranger, name);
            sighting = self.aosm.objects.remove(stranger);
        }
        let seen = sighting.filter(|seen| seen.position_std_m < ANYWHERE_STD_M);
        let is_seen = seen.is_some();
        object.position_std_m = LOST_STD_M;
        if let Some(seen) = seen {
            object.map_from_object = seen.map_from_object;
            object.position_std_m = seen.position_std_m;
        }
        self.aosm.objects.insert(name.to_owned(), object);
        Ok(is_seen)
    }

    /// Whether the origin of a pose is within the box about an object, as far as poses are known.
    fn is_within(&self, container: &str, map_from_object: &Pose) -> Result<bool, AgentError> {
        const MARGIN_M: f64 = 0.02;
        let container = self.aosm.object(container)?;
        let origin = Point3::from(map_from_object.translation.vector);
        let origin = container.map_from_object.inverse_transform_point(&origin);
        Ok(self
            .senses
            .bounds(&container.class)
            .is_some_and(|(low, high)| {
                (0..3).all(|i| (low[i] - MARGIN_M..=high[i] + MARGIN_M).contains(&origin[i]))
            }))
    }

    /// Whether the gripper still holds what it is believed to hold. If not, the object is looked for all around; one
    /// that is not seen is no longer known.
    pub(crate) fn check_grip(&mut self, name: &str) -> Result<Effect, AgentError> {
        if is_holding(self.robot.state()?.gripper_opening) {
            return Ok(Ok(()));
        }
        let map_from_base = pose_from_planar(&self.map_from_base()?, 0.0);
        let map_from_object = match self.base_from_held()? {
            Some(base_from_held) => map_from_base * base_from_held,
            None => self.aosm.object(name)?.map_from_object,
        };
        self.tcp_from_held = None;
        self.tuck()?;
        if !self.seek(name, &map_from_object, Self::look_around)? {
            self.aosm.objects.remove(name);
        }
        let object = name.to_owned();
        Ok(Err(Failure::Slipped { object }.to_string()))
    }
}
