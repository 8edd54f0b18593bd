//! What the robot makes of its sensors: where it is, how the home looks, and which objects stand where.

use std::collections::BTreeMap;

use factotum_control::Robot;
use factotum_descriptions::ObjectClass;
use factotum_geometry::cloud::{NearestPoints, PointCloud};
use factotum_geometry::frames::pose_from_planar;
use factotum_geometry::grid::OccupancyGrid;
use factotum_geometry::sensing::DepthFrame;
use factotum_geometry::{Pose, Pose2};
use factotum_perception::articulation::ArticulationParams;
use factotum_perception::class_surface::ClassAppearance;
use factotum_perception::detect::{DetectParams, Detection, Detector};
use factotum_perception::home_cloud::HomeCloud;
use factotum_perception::object_tracker::{ObjectTracker, TrackId, TrackerParams};
use factotum_perception::slam::{Slam2d, SlamParams};
use factotum_perception::visibility::{Presence, PresenceParams, presence};
use factotum_semantic_map::{Aosm, Location, ObjectSource};
use nalgebra::{Point2, Point3};

use crate::AgentError;

/// Edge of a voxel of the home's point cloud, metres.
const VOXEL_M: f64 = 0.03;
/// Depth is too poor beyond this for the point cloud, metres.
const CLOUD_RANGE_M: f64 = 3.0;
/// An object must have been seen this often before it is believed.
const N_SEEN_MIN: usize = 2;
/// Objects known this well are not fitted anew in passing, metres.
const SETTLED_M: f64 = 0.006;
/// That an object is gone is seen from no farther than this, metres...
const ABSENCE_RANGE_M: f64 = 2.0;
/// ...and in so many pictures without one that shows it.
const N_ABSENT_MIN: usize = 4;
/// Joint positions are read from no farther than this, metres.
const JOINT_RANGE_M: f64 = 1.6;

/// How carefully a picture is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Care {
    /// While driving: what is known well is passed over.
    InPassing,
    /// Before acting: everything counts.
    Close,
    /// After an action on joints: where things are is left as it was, since what an action turned looks displaced.
    Joints,
}

/// The robot's senses and what they have gathered.
pub(crate) struct Senses {
    slam: Slam2d,
    appearances: BTreeMap<String, ClassAppearance>,
    surfaces: BTreeMap<String, NearestPoints>,
    detector: Detector,
    tracker: ObjectTracker,
    cloud: HomeCloud,
    names: BTreeMap<TrackId, String>,
    /// Pictures in a row that show nothing where an object should be.
    n_absent: BTreeMap<String, usize>,
    map_from_odom: Pose2,
    position_std_m: f64,
    /// Where the last scan met something, in the odometry frame.
    felt_in_odom: Vec<Point2<f64>>,
}

impl Senses {
    /// Senses for a robot whose first scan is taken at `map_from_base`, in a home of which `map` is known, if any, and
    /// the surfaces `seen`.
    pub(crate) fn new<'a>(
        classes: impl Iterator<Item = &'a ObjectClass>,
        map_from_odom: Pose2,
        odom_from_base: &Pose2,
        map: Option<&OccupancyGrid>,
        seen: &PointCloud,
    ) -> Result<Self, AgentError> {
        let mut appearances = BTreeMap::new();
        for class in classes {
            appearances.insert(class.name.clone(), ClassAppearance::load(class)?);
        }
        let models = appearances
            .values()
            .map(|appearance| appearance.model.clone())
            .collect();
        let map_from_base = map_from_odom * odom_from_base;
        let params = SlamParams::default();
        Ok(Self {
            slam: match map {
                Some(map) => Slam2d::resume(map, map_from_base, params)?,
                None => Slam2d::new(map_from_base, params)?,
            },
            detector: Detector::new(models, DetectParams::default())?,
            surfaces: appearances
                .iter()
                .map(|(class, appearance)| {
                    (
                        class.clone(),
                        NearestPoints::new(appearance.model.surface.points()),
                    )
                })
                .collect(),
            appearances,
            tracker: ObjectTracker::new(TrackerParams::default()),
            cloud: HomeCloud::from_cloud(VOXEL_M, CLOUD_RANGE_M, seen),
            names: BTreeMap::new(),
            n_absent: BTreeMap::new(),
            map_from_odom,
            position_std_m: 0.0,
            felt_in_odom: Vec::new(),
        })
    }

    /// The correction of odometry's drift: where the odometry frame lies in the map.
    pub(crate) fn map_from_odom(&self) -> Pose2 {
        self.map_from_odom
    }

    /// The grid as mapped so far.
    pub(crate) fn map(&self) -> Option<&OccupancyGrid> {
        self.slam.map()
    }

    /// Where the last scan met something, in the odometry frame.
    pub(crate) fn felt_in_odom(&self) -> &[Point2<f64>] {
        &self.felt_in_odom
    }

    /// Samples of a class's surface, in Λ, to look up what is near them.
    pub(crate) fn surface(&self, class: &str) -> Option<&NearestPoints> {
        self.surfaces.get(class)
    }

    /// Surfaces seen by the camera, in the map frame.
    pub(crate) fn seen(&self) -> PointCloud {
        self.cloud.to_cloud(1)
    }

    /// Surfaces seen by the camera within about `radius_m` of a place, in the map frame.
    pub(crate) fn seen_near(
        &self,
        place: &Point2<f64>,
        radius_m: f64,
    ) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.cloud.near(place, radius_m)
    }

    /// Takes the surfaces of an earlier time for all that has been seen.
    pub(crate) fn remember(&mut self, seen: &PointCloud) {
        self.cloud = HomeCloud::from_cloud(VOXEL_M, CLOUD_RANGE_M, seen);
    }

    /// Takes a scan: where the robot is, and what the floor plan looks like.
    pub(crate) fn feel(&mut self, robot: &mut dyn Robot) -> Result<(), AgentError> {
        let scan = robot.scan()?;
        let update = self.slam.update(&scan.odom_from_base, &scan.data)?;
        self.map_from_odom = update.map_from_base * scan.odom_from_base.inverse();
        let hits = scan.data.hits_in_base().into_iter();
        self.felt_in_odom = hits.map(|hit| scan.odom_from_base * hit).collect();
        self.position_std_m = (update.covariance[(0, 0)] + update.covariance[(1, 1)])
            .max(0.0)
            .sqrt();
        Ok(())
    }

    /// Takes a picture: which objects stand where, and in which state.
    pub(crate) fn look(
        &mut self,
        robot: &mut dyn Robot,
        aosm: &mut Aosm,
        base_from_held: Option<Pose>,
        care: Care,
    ) -> Result<(), AgentError> {
        let picture = robot.look()?;
        let mut frame = picture.data;
        let footprint_m = robot.description().footprint_radius_m();
        blank_robot(&mut frame, footprint_m, base_from_held);
        let map_from_base = pose_from_planar(&(self.map_from_odom * picture.odom_from_base), 0.0);
        self.cloud.add(&map_from_base, &frame, |label| label == 0);
        let detections = match care {
            Care::Close | Care::Joints => self.detector.detect(&frame),
            Care::InPassing => {
                self.detector
                    .detect(&self.without_settled(&frame, &map_from_base, aosm))
            }
        };
        let mut detections = detections?;
        detections.retain(|detection| !is_held(detection, base_from_held));
        if care == Care::Joints {
            for detection in &detections {
                let map_from_object = map_from_base * detection.base_from_object;
                if let Some(name) = self.known_at(&detection.class, &map_from_object, aosm) {
                    self.read_joints(&name, detection, &frame, &map_from_base, aosm)?;
                }
            }
            return Ok(());
        }
        let tracks = self
            .tracker
            .observe(&map_from_base, self.position_std_m, &detections);
        for (track, detection) in tracks.into_iter().zip(&detections) {
            if let Some(name) = self.take_over(track, aosm)? {
                self.read_joints(&name, detection, &frame, &map_from_base, aosm)?;
            }
        }
        self.forget_gone(&frame, &map_from_base, aosm)
    }

    /// Brings a tracked object into the map, once it has been seen often enough.
    fn take_over(&mut self, track: TrackId, aosm: &mut Aosm) -> Result<Option<String>, AgentError> {
        let Some(tracked) = self.tracker.object(track) else {
            return Ok(None);
        };
        if tracked.n_seen < N_SEEN_MIN {
            return Ok(None);
        }
        let name = match self.names.get(&track) {
            Some(name) if aosm.objects.contains_key(name) => name.clone(),
            _ => {
                let name = match self.known_at(&tracked.class, &tracked.map_from_object, aosm) {
                    Some(name) => name,
                    None => aosm.add_object(
                        &tracked.class,
                        tracked.map_from_object,
                        ObjectSource::Seen,
                        tracked.sigma_m,
                    )?,
                };
                self.names.insert(track, name.clone());
                name
            }
        };
        let object = aosm.object_mut(&name)?;
        // Of several tracks of one object the surest is believed.
        let is_surest = tracked.sigma_m <= 1.5 * object.position_std_m.max(0.003);
        if object.location == Location::Loose && is_surest {
            object.map_from_object = tracked.map_from_object;
            object.position_std_m = tracked.sigma_m;
        }
        Ok(Some(name))
    }

    /// The known object of a class that a sighting of the class at a pose is of.
    ///
    /// One that is known about there, by an earlier day or a lost track, is the same; nor can two large things of a class
    /// stand in one another.
    fn known_at(&self, class: &str, map_from_object: &Pose, aosm: &Aosm) -> Option<String> {
        let gate_m = TrackerParams::default().gate_m + self.radius_m(class);
        let mut of_class = aosm.objects_of(class);
        let known = of_class.find(|object| {
            let apart =
                object.map_from_object.translation.vector - map_from_object.translation.vector;
            apart.norm() < gate_m
        });
        known.map(|object| object.name.clone())
    }

    /// The frame without labels of objects that are known well enough: fitting a pose takes time.
    fn without_settled(&self, frame: &DepthFrame, map_from_base: &Pose, aosm: &Aosm) -> DepthFrame {
        let mut frame = frame.clone();
        let settled: Vec<u16> = (1..=frame.label_classes.len() as u16)
            .filter(|label| {
                let class = &frame.label_classes[usize::from(*label) - 1];
                let Some(center) = frame.cloud_in_base(|l| l == *label).centroid() else {
                    return false;
                };
                let center = map_from_base * center;
                let reach_m = TrackerParams::default().gate_m + self.radius_m(class);
                aosm.objects_of(class).any(|object| {
                    object.position_std_m < SETTLED_M
                        && object.location == Location::Loose
                        && (Point3::from(object.map_from_object.translation.vector) - center).norm()
                            < reach_m
                })
            })
            .collect();
        for label in &mut frame.labels {
            if settled.contains(label) {
                *label = 0;
            }
        }
        frame
    }

    /// Corners of the box about a class's surface, in Λ, metres.
    pub(crate) fn bounds(&self, class: &str) -> Option<(Point3<f64>, Point3<f64>)> {
        self.appearances.get(class)?.model.surface.bounds()
    }

    /// Half the longest edge of a class's bounding box, metres.
    fn radius_m(&self, class: &str) -> f64 {
        self.bounds(class)
            .map_or(0.0, |(low, high)| (high - low).max() / 2.0)
    }

    fn read_joints(
        &self,
        name: &str,
        detection: &Detection,
        frame: &DepthFrame,
        map_from_base: &Pose,
        aosm: &mut Aosm,
    ) -> Result<(), AgentError> {
        if detection.distance_m > JOINT_RANGE_M {
            return Ok(());
        }
        let Some(appearance) = self.appearances.get(&detection.class) else {
            return Ok(());
        };
        let points: Vec<Point3<f64>> = frame
            .cloud_in_base(|label| label == detection.label)
            .points()
            .to_vec();
        let base_from_object = map_from_base.inverse() * aosm.object(name)?.map_from_object;
        for (joint, model) in &appearance.joints {
            let read = model.joint_state_from_cloud(
                &points,
                &base_from_object,
                &ArticulationParams::default(),
            );
            // Points that do not tell leave the belief as it is.
            if let Ok(read) = read {
                aosm.object_mut(name)?
                    .joints
                    .insert(joint.clone(), read.position);
            }
        }
        Ok(())
    }

    /// Forgets loose movable objects where the camera sees that there is nothing any more.
    fn forget_gone(
        &mut self,
        frame: &DepthFrame,
        map_from_base: &Pose,
        aosm: &mut Aosm,
    ) -> Result<(), AgentError> {
        let mut gone = Vec::new();
        for object in aosm
            .objects
            .values()
            .filter(|object| object.location == Location::Loose)
        {
            let is_movable = aosm
                .classes
                .get(&object.class)
                .is_some_and(|class| class.movable);
            let Some(appearance) = self.appearances.get(&object.class).filter(|_| is_movable)
            else {
                continue;
            };
            let base_from_object = map_from_base.inverse() * object.map_from_object;
            if base_from_object.translation.vector.norm() > ABSENCE_RANGE_M {
                continue;
            }
            let n_absent = self.n_absent.entry(object.name.clone()).or_insert(0);
            match presence(
                frame,
                &appearance.model,
                &base_from_object,
                &PresenceParams::default(),
            ) {
                Presence::Gone { .. } => *n_absent += 1,
                Presence::Seen { .. } => *n_absent = 0,
                Presence::Hidden | Presence::OutOfView => {}
            }
            if *n_absent >= N_ABSENT_MIN {
                gone.push(object.name.clone());
            }
        }
        for name in gone {
            self.n_absent.remove(&name);
            self.forget(&name);
            aosm.objects.remove(&name);
        }
        Ok(())
    }

    /// What was taken for the object `old` is `new`.
    pub(crate) fn rename(&mut self, old: &str, new: &str) {
        for name in self.names.values_mut().filter(|name| *name == old) {
            new.clone_into(name);
        }
    }

    /// Doubts where an object is, down to a standard deviation, metres: the next pictures say it anew.
    pub(crate) fn doubt(&mut self, name: &str, std_m: f64) {
        for track in self.tracks_of(name) {
            self.tracker.doubt(track, std_m);
        }
    }

    fn tracks_of(&self, name: &str) -> Vec<TrackId> {
        let named = self.names.iter().filter(|(_, known)| *known == name);
        named.map(|(track, _)| *track).collect()
    }

    /// Forgets the tracks of an object: it was moved, by the robot or by somebody else.
    pub(crate) fn forget(&mut self, name: &str) {
        for track in self.tracks_of(name) {
            self.names.remove(&track);
            self.tracker.forget(track);
        }
    }
}

/// The robot does not map itself nor what it holds: what is above its footprint or about its hand is left out.
fn blank_robot(frame: &mut DepthFrame, footprint_m: f64, base_from_held: Option<Pose>) {
    /// Reaches beyond anything the hand can hold, metres.
    const HELD_M: f64 = 0.2;
    let held = base_from_held.map(|pose| Point3::from(pose.translation.vector));
    for row in 0..frame.height {
        for column in 0..frame.width {
            let Some(point) = frame.point_in_optical(column, row) else {
                continue;
            };
            let point = frame.base_from_optical * point;
            let is_held = held.is_some_and(|held| (point - held).norm() < HELD_M);
            if is_held || point.xy().coords.norm() < footprint_m {
                frame.depth_m[row * frame.width + column] = 0.0;
            }
        }
    }
}

/// Whether a detection is what the gripper holds.
fn is_held(detection: &Detection, base_from_held: Option<Pose>) -> bool {
    const NEAR_M: f64 = 0.25;
    base_from_held.is_some_and(|held| {
        (held.translation.vector - detection.base_from_object.translation.vector).norm() < NEAR_M
    })
}
