//! Acting: what a skill is told, running it, and what its outcome means for the belief.

use factotum_geometry::frames::pose_from_planar;
use factotum_geometry::{Pose, Pose2};
use factotum_motion::{Obstacle, PlanningScene};
use factotum_semantic_map::{Location, OptionKind, OptionSpec};
use factotum_skills::{
    ArmMotion, Articulate, Failure, HeldView, ObjectView, Outcome, Pick, Place, Situation, Skill,
};
use nalgebra::Point3;

use crate::surroundings::{obstacles_from_points, walls_beyond_view, without_object};
use crate::{AgentError, Executive, LogLevel};

impl Executive<'_> {
    /// Runs a skill for an option from where the robot stands and takes note of what came of it.
    pub(crate) fn act(
        &mut self,
        option: &OptionSpec,
        skill: &dyn Skill,
    ) -> Result<Result<(), String>, AgentError> {
        if matches!(option.kind, OptionKind::Place { .. })
            && let Err(lost) = self.check_grip(&option.object)?
        {
            return Ok(Err(lost));
        }
        let situation = {
            let map_from_base = self.map_from_base()?;
            self.situation(option, &map_from_base)?
        };
        let sought = situation.target.as_ref().unwrap_or(&situation.object);
        let at = sought.base_from_object.translation;
        self.log(
            LogLevel::Info,
            format!(
                "{} {}, {:.3} m ahead, {:.3} m to the left, {:.3} m up",
                skill.name(),
                option.object,
                at.x,
                at.y,
                at.z
            ),
        )?;
        let outcome = skill.run(self.robot, &situation, &mut self.rng)?;
        match (outcome, &option.kind) {
            (Outcome::Done { tcp_from_held, .. }, OptionKind::Pick) => {
                self.tcp_from_held = tcp_from_held;
                self.aosm.object_mut(&option.object)?.location = Location::Held;
                self.tuck()?;
                self.check_grip(&option.object)
            }
            (Outcome::Done { .. }, OptionKind::Place { target, .. }) => {
                self.tcp_from_held = None;
                self.tuck()?;
                self.check_placed(&option.object, target)
            }
            (Outcome::Done { joints, .. }, OptionKind::Articulate { action }) => {
                self.aosm.object_mut(&option.object)?.joints.extend(joints);
                self.tuck()?;
                self.check_turned(&option.object, action)
            }
            (Outcome::Failed(Failure::OnRequest), _) => Err(AgentError::Stopped),
            (Outcome::Failed(failure), kind) => {
                match kind {
                    OptionKind::Pick => {}
                    OptionKind::Place { .. } => {
                        self.check_grip(&option.object)?.ok();
                    }
                    // The tool may have stopped short of its goal, and the joint not.
                    OptionKind::Articulate { action } => {
                        self.tuck()?;
                        if action.effect.is_some()
                            && self.check_turned(&option.object, action)?.is_ok()
                        {
                            self.log(LogLevel::Warning, format!("done, although {failure}"))?;
                            return Ok(Ok(()));
                        }
                    }
                }
                Ok(Err(failure.to_string()))
            }
        }
    }

    /// What a skill is told: everything believed, seen from a base pose.
    pub(crate) fn situation(
        &self,
        option: &OptionSpec,
        map_from_base: &Pose2,
    ) -> Result<Situation, AgentError> {
        let base_from_map = pose_from_planar(map_from_base, 0.0).inverse();
        let target = match &option.kind {
            OptionKind::Place { target, .. } => Some(target.as_str()),
            OptionKind::Pick | OptionKind::Articulate { .. } => None,
        };
        Ok(Situation {
            robot: self.model.clone(),
            obstacles: self.obstacles(
                &base_from_map,
                &[option.object.as_str(), target.unwrap_or_default()],
            )?,
            object: self.view(&option.object, &base_from_map)?,
            target: target
                .map(|target| self.view(target, &base_from_map))
                .transpose()?,
            held: self.held_view()?,
        })
    }

    fn view(&self, name: &str, base_from_map: &Pose) -> Result<ObjectView, AgentError> {
        let object = self.aosm.object(name)?;
        Ok(ObjectView {
            name: name.to_owned(),
            class: self.aosm.class(&object.class)?.clone(),
            base_from_object: base_from_map * object.map_from_object,
            joints: object.joints.clone(),
        })
    }

    fn held_view(&self) -> Result<Option<HeldView>, AgentError> {
        let Some((object, tcp_from_object)) = self.aosm.held().zip(self.tcp_from_held) else {
            return Ok(None);
        };
        let class = self.aosm.class(&object.class)?.clone();
        Ok(Some(HeldView {
            name: object.name.clone(),
            class,
            tcp_from_object,
        }))
    }

    /// Pose of what the gripper holds, in the base frame.
    pub(crate) fn base_from_held(&mut self) -> Result<Option<Pose>, AgentError> {
        let Some(tcp_from_held) = self.tcp_from_held else {
            return Ok(None);
        };
        let state = self.robot.state()?;
        let q = self.model.q_from_state(state.lift_m, &state.arm_positions);
        Ok(Some(self.model.chain().base_from_tcp(&q) * tcp_from_held))
    }

    /// What the arm must keep clear of: seen surfaces, and known objects but for `without` and what is held.
    fn obstacles(
        &self,
        base_from_map: &Pose,
        without: &[&str],
    ) -> Result<Vec<Obstacle>, AgentError> {
        /// Objects farther than this are out of the arm's way, metres.
        const NEAR_M: f64 = 2.0;
        let place = Point3::from(base_from_map.inverse().translation.vector).xy();
        let mut seen: Vec<Point3<f64>> = self.senses.seen_near(&place, NEAR_M).collect();
        seen.extend(walls_beyond_view(&self.aosm.grid, &place, &seen));
        let mut points: Vec<Point3<f64>> = seen
            .iter()
            .map(|point| base_from_map * point)
            .filter(|point| point.xy().coords.norm() < NEAR_M)
            .collect();
        let mut obstacles = Vec::new();
        for object in self.aosm.objects.values() {
            // Where the held object stood, the cloud may still hold points of it.
            let is_there = match object.location {
                Location::Loose => true,
                Location::Held => false,
                Location::In(_) => continue,
            };
            let view = self.view(&object.name, base_from_map)?;
            if view.base_from_object.translation.vector.norm() > NEAR_M {
                continue;
            }
            if let Some(surface) = self.senses.surface(&object.class) {
                without_object(
                    &mut points,
                    &view.base_from_object,
                    surface,
                    view.class.movable,
                );
            }
            if is_there && !without.contains(&object.name.as_str()) {
                obstacles.push(view.as_obstacle());
            }
        }
        obstacles.extend(obstacles_from_points(&points));
        Ok(obstacles)
    }

    /// Brings the arm to its driving posture, clear of everything seen, unless it is there.
    pub(crate) fn tuck(&mut self) -> Result<(), AgentError> {
        /// An arm this near to a posture is in it, rad or m.
        const THERE: f64 = 0.05;
        let rest = self.model.q_rest();
        let state = self.robot.state()?;
        let q = self.model.q_from_state(state.lift_m, &state.arm_positions);
        if q.iter()
            .zip(&rest)
            .all(|(q, rest)| (q - rest).abs() < THERE)
        {
            return Ok(());
        }
        let map_from_base = self.map_from_base()?;
        let base_from_map = pose_from_planar(&map_from_base, 0.0).inverse();
        let held = self.held_view()?.map(|held| held.as_held());
        let obstacles = self.obstacles(&base_from_map, &[])?;
        let mut scene = PlanningScene::new(&self.model, &obstacles, held.as_ref())?;
        let tucked = ArmMotion::new(self.robot, &self.model, &mut self.rng)
            .go_to_posture(&mut scene, &rest, "rest")?;
        if let Err(failure) = tucked {
            self.log(LogLevel::Warning, format!("cannot tuck the arm: {failure}"))?;
        }
        Ok(())
    }
}

/// The given skill that does an option.
pub(crate) fn skill_for(option: &OptionSpec) -> Box<dyn Skill> {
    match &option.kind {
        OptionKind::Pick => Box::new(Pick),
        OptionKind::Place { action, .. } => Box::new(Place {
            target_from_object: action.place.unwrap_or_default().into(),
        }),
        OptionKind::Articulate { action } => Box::new(Articulate {
            action: action.clone(),
        }),
    }
}
