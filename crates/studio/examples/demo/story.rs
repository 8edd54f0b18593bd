//! The story: what happens when, and what of it is published.

use std::f64::consts::TAU;

use factotum_protocol::{
    Activity, Aosm, AosmEdge, AosmObject, BasePath, BodyPose, Done, Drive, Event, EventLevel,
    NavigationRegion, ObjectClass, OccupancyMap, Plan, PlanStep, Pose, PosePlanar, Provenance,
    ServerMessage, State, Status, StepKind, StepState,
};
use factotum_studio::StudioHandle;

use crate::home::{self, Grid, at};
use crate::robot::{self, Arm, TUCKED};

const DRIVE_M_PER_SEC: f64 = 0.8;
const TURN_RAD_PER_SEC: f64 = 1.6;
const ARM_RAD_PER_SEC: f64 = 1.3;
/// A hand that says nothing for so long has let go.
const HAND_SECS: f64 = 0.4;
const MAP_PERIOD_SECS: f64 = 0.5;
const BASE_RADIUS_M: f64 = 0.36;

/// One thing after another.
#[derive(Clone)]
enum Beat {
    Drive(Vec<[f64; 2]>),
    Face([f64; 2]),
    /// Brings the hand to a point.
    Reach([f64; 3]),
    Tuck,
    Take,
    /// Lets go, and what was held is here now.
    Drop([f64; 3]),
    Say(EventLevel, &'static str),
    Activity(Activity),
    Understand,
    /// What is now known of an object.
    Know(usize, &'static str, [f64; 3]),
    Step(usize, StepState, &'static str),
    Wait(f64),
    End,
}

pub(crate) struct Story {
    beats: std::vec::IntoIter<Beat>,
    current: Option<Beat>,
    waited_secs: f64,
    time_secs: f64,
    map_at_secs: f64,
    base: PosePlanar,
    arm: Arm,
    bottle: Pose,
    holding: bool,
    grid: Grid,
    aosm: Aosm,
    plan: Plan,
    status: Status,
    /// What a hand wishes, and for how long yet.
    hand: (Drive, f64),
    over: bool,
}

impl Story {
    pub(crate) fn begin(studio: &StudioHandle) -> Self {
        studio.publish(ServerMessage::Scene(home::scene()));
        studio.publish(ServerMessage::Scene(robot::scene()));
        let story = Self {
            beats: beats().into_iter(),
            current: None,
            waited_secs: 0.0,
            time_secs: 0.0,
            map_at_secs: 0.0,
            base: PosePlanar {
                x: 3.4,
                y: 1.6,
                yaw: 1.2,
            },
            arm: TUCKED,
            bottle: at(home::BOTTLE),
            holding: false,
            grid: Grid::of_home(),
            aosm: Aosm::default(),
            plan: Plan::default(),
            status: Status {
                goal: "Tidy up: bottle in the bin, light off, faucet closed".to_owned(),
                activity: Activity::Starting,
                paused: false,
                takes_driving: false,
            },
            hand: (Drive::default(), 0.0),
            over: false,
        };
        story.show_status(studio);
        story
    }

    pub(crate) fn time_secs(&self) -> f64 {
        self.time_secs
    }

    pub(crate) fn is_over(&self) -> bool {
        self.over
    }

    pub(crate) fn set_paused(&mut self, paused: bool, studio: &StudioHandle) {
        self.status.paused = paused;
        self.show_status(studio);
    }

    pub(crate) fn stop(&mut self, studio: &StudioHandle) {
        self.over = true;
        self.status.activity = Activity::Stopped;
        self.say(EventLevel::Warning, "stopped by a person", studio);
        studio.publish(ServerMessage::Done(Done {
            achieved: false,
            summary: "Stopped by a person before the plan was done.".to_owned(),
        }));
    }

    /// The story waits for a person who drives, or goes on.
    pub(crate) fn take_driving(&mut self, takes_driving: bool, studio: &StudioHandle) {
        if self.status.takes_driving != takes_driving {
            self.status.takes_driving = takes_driving;
            let what = if takes_driving { "begins" } else { "ends" };
            self.say(EventLevel::Info, &format!("driving by hand {what}"), studio);
            self.show_status(studio);
        }
    }

    /// Takes the velocity that a hand wishes, and says so when it is another.
    pub(crate) fn drive_by_hand(&mut self, drive: Drive, studio: &StudioHandle) {
        if drive != self.hand.0 {
            let Drive {
                forward,
                left,
                turn,
            } = drive;
            let text = format!("hand: forward {forward}, left {left}, turn {turn}");
            self.say(EventLevel::Info, &text, studio);
        }
        self.hand = (drive, HAND_SECS);
    }

    /// Moves the base as the hand wishes, until it falls silent; there are no walls for it.
    fn follow_hand(&mut self, dt: f64) {
        let (drive, left_secs) = self.hand;
        self.hand.1 = (left_secs - dt).max(0.0);
        if left_secs <= 0.0 {
            return;
        }
        let (sin, cos) = self.base.yaw.sin_cos();
        self.base.x += DRIVE_M_PER_SEC * dt * (cos * drive.forward - sin * drive.left);
        self.base.y += DRIVE_M_PER_SEC * dt * (sin * drive.forward + cos * drive.left);
        self.base.yaw += TURN_RAD_PER_SEC * dt * drive.turn;
        self.carry();
    }

    /// Lets `dt` seconds pass.
    pub(crate) fn advance(&mut self, dt: f64, studio: &StudioHandle) {
        self.time_secs += dt;
        if self.status.takes_driving {
            self.follow_hand(dt);
            self.show_map_in_time(studio);
            return;
        }
        let mut beat = match self.current.take().or_else(|| self.beats.next()) {
            Some(beat) => beat,
            None => return,
        };
        let finished = self.play(&mut beat, dt, studio);
        if !finished {
            self.current = Some(beat);
        }
        if self.status.activity == Activity::Exploring {
            self.show_map_in_time(studio);
        }
    }

    fn show_map_in_time(&mut self, studio: &StudioHandle) {
        if self.time_secs >= self.map_at_secs {
            self.map_at_secs = self.time_secs + MAP_PERIOD_SECS;
            self.grid.look_around([self.base.x, self.base.y]);
            self.show_map(studio);
        }
    }

    /// Publishes where everything is.
    pub(crate) fn show(&self, sim_speed: f64, studio: &StudioHandle) {
        let mut body_poses = robot::poses(self.base, self.arm);
        body_poses.push(BodyPose {
            name: "bottle".to_owned(),
            pose: self.bottle,
        });
        studio.publish(ServerMessage::State(State {
            time_secs: self.time_secs,
            sim_speed,
            base: self.base,
            body_poses,
            joints: robot::joints(self.arm),
        }));
    }

    /// Plays a beat for `dt`; true when it is finished.
    fn play(&mut self, beat: &mut Beat, dt: f64, studio: &StudioHandle) -> bool {
        match beat {
            Beat::Drive(points) => self.drive(points, dt, studio),
            Beat::Face(point) => {
                let wanted = (point[1] - self.base.y).atan2(point[0] - self.base.x);
                self.turn(wanted, TURN_RAD_PER_SEC * dt)
            }
            Beat::Reach(point) => {
                let wanted = robot::reach(self.base, *point);
                self.move_arm(wanted, dt)
            }
            Beat::Tuck => self.move_arm(TUCKED, dt),
            Beat::Take => {
                self.holding = true;
                true
            }
            Beat::Drop(position) => {
                self.holding = false;
                self.bottle = at(*position);
                true
            }
            Beat::Say(level, text) => {
                self.say(*level, text, studio);
                true
            }
            Beat::Activity(activity) => {
                self.status.activity = *activity;
                self.show_status(studio);
                true
            }
            Beat::Understand => {
                self.aosm = aosm(&self.grid);
                studio.publish(ServerMessage::Aosm(self.aosm.clone()));
                self.plan = plan();
                studio.publish(ServerMessage::Plan(self.plan.clone()));
                true
            }
            Beat::Know(index, state, position) => {
                let object = &mut self.aosm.objects[*index];
                object.state = (*state).to_owned();
                object.pose = at(*position);
                studio.publish(ServerMessage::Aosm(self.aosm.clone()));
                true
            }
            Beat::Step(index, state, reason) => {
                let step = &mut self.plan.steps[*index];
                let retried = *state == StepState::Running && step.state == StepState::Running;
                if *state == StepState::Running {
                    step.attempts += 1;
                }
                step.state = *state;
                if retried || !reason.is_empty() {
                    step.reason = (*reason).to_owned();
                }
                studio.publish(ServerMessage::Plan(self.plan.clone()));
                true
            }
            Beat::Wait(secs) => {
                self.waited_secs += dt;
                let finished = self.waited_secs >= *secs;
                if finished {
                    self.waited_secs = 0.0;
                }
                finished
            }
            Beat::End => {
                self.over = true;
                self.status.activity = Activity::Finished;
                self.show_status(studio);
                studio.publish(ServerMessage::Done(Done {
                    achieved: true,
                    summary: "The bottle is in the bin, the light is off and the faucet is closed."
                        .to_owned(),
                }));
                true
            }
        }
    }

    fn drive(&mut self, points: &mut Vec<[f64; 2]>, dt: f64, studio: &StudioHandle) -> bool {
        let Some(&next) = points.first() else {
            studio.publish(ServerMessage::BasePath(BasePath { points: Vec::new() }));
            return true;
        };
        let (dx, dy) = (next[0] - self.base.x, next[1] - self.base.y);
        let distance = dx.hypot(dy);
        let step = (DRIVE_M_PER_SEC * dt).min(distance);
        if distance > 1e-6 {
            self.base.x += dx / distance * step;
            self.base.y += dy / distance * step;
            if distance > 0.05 {
                self.turn(dy.atan2(dx), TURN_RAD_PER_SEC * dt);
            }
        }
        if step >= distance {
            points.remove(0);
        }
        let mut path = vec![[self.base.x, self.base.y]];
        path.extend(points.iter());
        studio.publish(ServerMessage::BasePath(BasePath { points: path }));
        self.carry();
        false
    }

    fn turn(&mut self, wanted: f64, step_rad: f64) -> bool {
        let error = (wanted - self.base.yaw + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        self.base.yaw += error.clamp(-step_rad, step_rad);
        self.carry();
        error.abs() <= step_rad
    }

    fn move_arm(&mut self, wanted: Arm, dt: f64) -> bool {
        let farthest = (0..wanted.len())
            .map(|joint| (wanted[joint] - self.arm[joint]).abs())
            .fold(0.0, f64::max);
        let part = (ARM_RAD_PER_SEC * dt / farthest.max(1e-9)).min(1.0);
        for (joint, wanted) in self.arm.iter_mut().zip(wanted) {
            *joint += (wanted - *joint) * part;
        }
        self.carry();
        part >= 1.0
    }

    fn carry(&mut self) {
        if self.holding {
            let links = robot::poses(self.base, self.arm);
            self.bottle = robot::held(&links).unwrap_or(self.bottle);
        }
    }

    fn say(&self, level: EventLevel, text: &str, studio: &StudioHandle) {
        studio.publish(ServerMessage::Event(Event {
            level,
            text: text.to_owned(),
            time_secs: self.time_secs,
        }));
    }

    fn show_status(&self, studio: &StudioHandle) {
        studio.publish(ServerMessage::Status(self.status.clone()));
    }

    fn show_map(&self, studio: &StudioHandle) {
        let origin = PosePlanar {
            x: home::ORIGIN[0],
            y: home::ORIGIN[1],
            yaw: 0.0,
        };
        let cells = self.grid.seen();
        let map =
            OccupancyMap::from_cells(home::WIDTH, home::HEIGHT, home::RESOLUTION_M, origin, cells);
        if let Ok(map) = map {
            studio.publish(ServerMessage::Map(map));
        }
    }
}

/// Places from which the robot acts.
const BY_TABLE: [f64; 2] = [2.1, 3.15];
const BY_BIN: [f64; 2] = [6.75, 0.75];
const BY_SWITCH: [f64; 2] = [3.75, 3.7];
const BY_FAUCET: [f64; 2] = [6.8, 2.65];
/// Both sides of the doorway.
const DOORWAY: [[f64; 2]; 2] = [[4.0, 2.8], [5.3, 2.8]];

fn beats() -> Vec<Beat> {
    use Beat::{
        Activity as At, Drive, Drop, End, Face, Know, Reach, Say, Step, Take, Tuck, Understand,
        Wait,
    };
    use EventLevel::{Info, Warning};
    use StepState::{Done, Running};
    let [living, kitchen] = DOORWAY;
    let above_bin = [home::BIN[0], home::BIN[1], 0.85];
    let grip = [home::BOTTLE[0], home::BOTTLE[1], home::BOTTLE[2] + 0.09];
    vec![
        Wait(0.5),
        At(Activity::Exploring),
        Say(Info, "looking around to build the map"),
        Drive(vec![[3.6, 2.4], [3.3, 3.4], [3.6, 5.2], [3.7, 3.4], living]),
        Say(Info, "found a side table with a bottle"),
        Drive(vec![kitchen, [6.5, 3.6], [6.7, 2.0], [6.0, 1.2]]),
        Say(Info, "found a sink with a faucet, and a bin"),
        Drive(vec![[5.4, 2.6], [5.3, 2.8]]),
        At(Activity::Planning),
        Say(Info, "the map is closed: 4 object classes, 4 objects"),
        Wait(1.0),
        Understand,
        Say(Info, "plan found: 8 steps"),
        Wait(0.5),
        At(Activity::Acting),
        Step(0, Running, ""),
        Drive(vec![living, [3.2, 3.1], BY_TABLE]),
        Face([home::BOTTLE[0], home::BOTTLE[1]]),
        Step(0, Done, ""),
        Step(1, Running, ""),
        Reach(grip),
        Wait(0.4),
        Say(
            Warning,
            "the bottle slipped while it was lifted; trying another grasp",
        ),
        Step(
            1,
            Running,
            "The first grasp slipped; a second one from the side is tried.",
        ),
        Reach([grip[0], grip[1], grip[2] + 0.2]),
        Reach(grip),
        Take,
        Know(0, "in hand", home::BOTTLE),
        Wait(0.4),
        Reach([grip[0], grip[1], grip[2] + 0.2]),
        Tuck,
        Step(1, Done, ""),
        Step(2, Running, ""),
        Drive(vec![[3.2, 3.1], living, kitchen, [6.2, 1.6], BY_BIN]),
        Face([home::BIN[0], home::BIN[1]]),
        Step(2, Done, ""),
        Step(3, Running, ""),
        Reach(above_bin),
        Drop([home::BIN[0], home::BIN[1], 0.3]),
        Say(Info, "the bottle is in the bin"),
        Know(0, "in bin", [home::BIN[0], home::BIN[1], 0.9]),
        Wait(0.4),
        Tuck,
        Step(3, Done, ""),
        Step(4, Running, ""),
        Drive(vec![[6.2, 1.6], BY_FAUCET]),
        Face([home::FAUCET[0], home::FAUCET[1]]),
        Step(4, Done, ""),
        Step(5, Running, ""),
        Reach(home::FAUCET),
        Wait(1.0),
        Say(Info, "the faucet is closed"),
        Know(3, "closed", home::FAUCET),
        Tuck,
        Step(5, Done, ""),
        Step(6, Running, ""),
        Drive(vec![kitchen, living, BY_SWITCH]),
        Face([home::SWITCH[0], home::SWITCH[1]]),
        Step(6, Done, ""),
        Step(7, Running, ""),
        Reach(home::SWITCH),
        Wait(0.6),
        Say(Info, "the light is off"),
        Know(2, "off", home::SWITCH),
        Tuck,
        Step(7, Done, ""),
        End,
    ]
}

fn plan() -> Plan {
    use StepKind::{Manipulate, Navigate};
    let steps = [
        (Navigate, "go_to", vec!["side table"]),
        (Manipulate, "pick_up", vec!["bottle"]),
        (Navigate, "go_to", vec!["bin"]),
        (Manipulate, "throw_away", vec!["bottle"]),
        (Navigate, "go_to", vec!["sink"]),
        (Manipulate, "close", vec!["faucet"]),
        (Navigate, "go_to", vec!["light switch"]),
        (Manipulate, "turn_off", vec!["light"]),
    ];
    let steps = (0..)
        .zip(steps)
        .map(|(index, (kind, action, args))| PlanStep {
            index,
            kind,
            action: action.to_owned(),
            args: args.into_iter().map(str::to_owned).collect(),
            state: StepState::Pending,
            attempts: 0,
            reason: String::new(),
        });
    Plan {
        replans: 0,
        steps: steps.collect(),
    }
}

fn aosm(grid: &Grid) -> Aosm {
    let things = [
        (
            "bottle",
            "bottle",
            "on the side table",
            home::BOTTLE,
            "pick_up",
            "pick up bottle",
        ),
        (
            "bin",
            "bin",
            "",
            home::BIN,
            "throw_away",
            "throw away at bin",
        ),
        (
            "light switch",
            "light_switch",
            "on",
            home::SWITCH,
            "turn_off",
            "turn light off",
        ),
        (
            "faucet",
            "faucet",
            "open",
            home::FAUCET,
            "close",
            "close faucet",
        ),
    ];
    let mut aosm = Aosm::default();
    for (index, (name, class, state, position, action, option)) in (0..).zip(things) {
        aosm.classes.push(ObjectClass {
            name: class.to_owned(),
            actions: vec![action.to_owned()],
            provenance: Provenance::Taught,
        });
        aosm.objects.push(AosmObject {
            name: name.to_owned(),
            class: class.to_owned(),
            pose: at(position),
            state: state.to_owned(),
        });
        aosm.regions.push(NavigationRegion {
            name: format!("n_{class}"),
            option: option.to_owned(),
            object: name.to_owned(),
            colour_index: index,
            poses: around([position[0], position[1]], grid),
        });
    }
    for from in &aosm.regions {
        for to in &aosm.regions {
            if from.name < to.name {
                aosm.edges.push(AosmEdge {
                    from: from.name.clone(),
                    to: to.name.clone(),
                    length_m: 4.0,
                });
            }
        }
    }
    aosm
}

/// Free base poses at arm's length around a point in the same room, looking at it.
fn around(point: [f64; 2], grid: &Grid) -> Vec<[f64; 3]> {
    let same_room = |x: f64| (x < 4.6) == (point[0] < 4.6);
    let mut poses = Vec::new();
    // A golden-angle spiral fills the ring evenly and is the same every time.
    for index in 0..160 {
        let part = f64::from(index) / 160.0;
        let radius = (0.8_f64.powi(2) + part * (1.25_f64.powi(2) - 0.8_f64.powi(2))).sqrt();
        let angle = f64::from(index) * 2.399_963;
        let at = [
            point[0] + radius * angle.cos(),
            point[1] + radius * angle.sin(),
        ];
        let inside = (0.0..8.0).contains(&at[0]) && (0.0..6.0).contains(&at[1]);
        if inside && same_room(at[0]) && grid.is_free(at, BASE_RADIUS_M) {
            poses.push([at[0], at[1], (point[1] - at[1]).atan2(point[0] - at[0])]);
        }
    }
    poses
}
