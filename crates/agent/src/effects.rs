//! Effects: what an action was to bring about, and what a look says of it.

use std::collections::BTreeSet;

use factotum_descriptions::ActionSpec;
use factotum_geometry::Pose;
use factotum_semantic_map::Location;
use factotum_skills::Failure;
use nalgebra::Point3;

use crate::{AgentError, Executive};

/// Opening of the gripper below which it holds nothing, as a fraction.
const EMPTY_OPENING: f64 = 0.06;

/// How far outside the interval of a state a joint may be read and still count, as a share of the interval.
const EFFECT_MARGIN: f64 = 0.5;

/// An effect that was looked for: there, or why it is not.
type Effect = Result<(), String>;

impl Executive<'_> {
    /// Whether a joint is believed to be where an action was to bring it.
    pub(crate) fn check_effect(
        &self,
        name: &str,
        action: &ActionSpec,
    ) -> Result<Effect, AgentError> {
        let object = self.aosm.object(name)?;
        let class = self.aosm.class(&object.class)?;
        let expected = action
            .effect
            .as_deref()
            .and_then(|effect| class.state(effect));
        let Some((expected, position)) =
            expected.and_then(|state| Some((state, *object.joints.get(&state.joint)?)))
        else {
            return Ok(Ok(()));
        };
        // A joint pushed against its stop is believed a little beyond it.
        let [lower, upper] = expected.range;
        let margin = EFFECT_MARGIN * (upper - lower);
        if (lower - margin..=upper + margin).contains(&position) {
            return Ok(Ok(()));
        }
        Ok(Err(format!(
            "`{name}` is not {}: its {} is at {position:.2}",
            expected.name, expected.joint
        )))
    }

    /// Whether an object that was let go is in its target, by a look: it is believed to be there unless it is seen
    /// elsewhere.
    pub(crate) fn check_placed(&mut self, name: &str, target: &str) -> Result<Effect, AgentError> {
        let map_from_target = self.aosm.object(target)?.map_from_object;
        let mut object = self.aosm.object(name)?.clone();
        object.location = Location::Loose;
        object.map_from_object = map_from_target;
        object.position_std_m = f64::INFINITY;
        self.aosm.objects.insert(name.to_owned(), object.clone());
        self.senses.forget(name);
        let names = |this: &Self| -> BTreeSet<String> {
            let objects = this.aosm.objects_of(&object.class);
            objects.map(|object| object.name.clone()).collect()
        };
        let known = names(self);
        self.look_closely()?;
        let strangers: Vec<String> = names(self).difference(&known).cloned().collect();

        // What turns up now and was not known before is what was let go.
        let mut seen_at = None;
        for stranger in strangers {
            self.senses.rename(&stranger, name);
            seen_at = self.aosm.objects.remove(&stranger);
        }
        let seen_at = seen_at
            .as_ref()
            .or_else(|| self.aosm.objects.get(name))
            .filter(|seen| seen.position_std_m.is_finite())
            .map(|seen| (seen.map_from_object, seen.position_std_m));
        match seen_at {
            Some((map_from_object, std_m)) if !self.is_within(target, &map_from_object)? => {
                object.map_from_object = map_from_object;
                object.position_std_m = std_m;
                self.aosm.objects.insert(name.to_owned(), object);
                Ok(Err(format!("`{name}` is seen outside `{target}`")))
            }
            seen => {
                object.location = Location::In(target.to_owned());
                if let Some((map_from_object, std_m)) = seen {
                    object.map_from_object = map_from_object;
                    object.position_std_m = std_m;
                }
                self.aosm.objects.insert(name.to_owned(), object);
                Ok(Ok(()))
            }
        }
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

    /// Whether the gripper is stopped by something between its fingers.
    pub(crate) fn is_gripping(&mut self) -> Result<bool, AgentError> {
        Ok(self.robot.state()?.gripper_opening > EMPTY_OPENING)
    }

    /// Whether the gripper still holds what it is believed to hold; if not, the belief is mended.
    pub(crate) fn check_grip(&mut self, object: &str) -> Result<Effect, AgentError> {
        if self.is_gripping()? {
            return Ok(Ok(()));
        }
        self.let_go(object)?;
        let object = object.to_owned();
        Ok(Err(Failure::Slipped { object }.to_string()))
    }

    /// Believes that the gripper holds nothing any more.
    pub(crate) fn let_go(&mut self, object: &str) -> Result<(), AgentError> {
        self.tcp_from_held = None;
        self.aosm.object_mut(object)?.location = Location::Loose;
        Ok(())
    }
}
