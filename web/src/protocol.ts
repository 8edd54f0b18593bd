// Generated from crates/protocol; do not edit. To bring it up to date:
//   cargo run -p factotum-protocol --example codegen

export const VERSION = 3;

/**
 * From studio to page.
 */
export type ServerMessage = { "type": "hello" } & Hello | { "type": "scene" } & Scene | { "type": "state" } & State | { "type": "map" } & OccupancyMap | { "type": "aosm" } & Aosm | { "type": "plan" } & Plan | { "type": "base_path" } & BasePath | { "type": "status" } & Status | { "type": "control" } & Control | { "type": "event" } & Event | { "type": "done" } & Done | { "type": "trainings" } & Trainings | { "type": "teaching" } & Teaching | { "type": "edit_answer" } & EditAnswer;

/**
 * From page to studio.
 */
export type ClientMessage = { "type": "pause" } | { "type": "resume" } | { "type": "stop" } | { "type": "drive" } & Drive | { "type": "drive_done" } | { "type": "edit" } & EditRequest;

/**
 * A velocity of the base, as shares of the robot's limits: each in `[-1, 1]`. Any other number is refused when it is
 * read.
 */
export type Drive = {
  /**
   * Ahead; backwards when negative.
   */
  forward: number,
  /**
   * Sideways to the left; to the right when negative.
   */
  left: number,
  /**
   * Turning counterclockwise; clockwise when negative.
   */
  turn: number, };

/**
 * Who is speaking.
 */
export type Hello = {
  /**
   * The sender's `VERSION`.
   */
  version: number,
  /**
   * Random name of this run of the studio: a page that comes back to another one knows it.
   */
  session: string,
  /**
   * Name of this connection, as in `Control::owner`.
   */
  client: string,
  /**
   * What the page may do.
   */
  role: Role, };

/**
 * What a page may do. Each role may do what those before it may.
 */
export type Role = "view" | "teach" | "execute";

/**
 * Whose commands the robot follows.
 */
export type Control = {
  /**
   * `Hello::client` of the page that has the robot; none when it is free. The first that
   * commands it has it until it leaves, or until another commands after it has long said nothing.
   */
  owner: string | null, };

/**
 * A pose in space.
 */
export type Pose = {
  /**
   * Position, in metres.
   */
  position: [number, number, number],
  /**
   * Orientation as a unit quaternion `[x, y, z, w]`.
   */
  orientation_xyzw: [number, number, number, number], };

/**
 * A pose on the floor.
 */
export type PosePlanar = {
  /**
   * Position along x, in metres.
   */
  x: number,
  /**
   * Position along y, in metres.
   */
  y: number,
  /**
   * Heading about z, in radians; 0 looks along x.
   */
  yaw: number, };

/**
 * The bodies of one source; a later scene of the same source replaces it.
 */
export type Scene = {
  /**
   * Where these bodies come from.
   */
  source: SceneSource,
  /**
   * The bodies. Names are unique over the scenes of all sources.
   */
  bodies: Array<Body>, };

/**
 * Where a scene comes from, which decides how it is drawn.
 */
export type SceneSource = "robot" | "home" | "belief";

/**
 * A rigid body.
 */
export type Body = {
  /**
   * Name by which `State` moves it.
   */
  name: string,
  /**
   * World from body, until a state says otherwise.
   */
  pose: Pose,
  /**
   * Its shapes.
   */
  shapes: Array<Shape>, };

/**
 * A geometry fixed to a body.
 */
export type Shape = {
  /**
   * What it is.
   */
  geometry: Geometry,
  /**
   * Body from shape.
   */
  pose: Pose,
  /**
   * Red, green, blue (sRGB) and opacity, each 0 to 1.
   */
  rgba: [number, number, number, number], };

/**
 * A geometry, centred on its own origin. Long axes lie along z.
 */
export type Geometry = { "kind": "box",
  /**
   * Half its edges along x, y and z.
   */
  half_extents_m: [number, number, number], } | { "kind": "sphere",
  /**
   * Radius.
   */
  radius_m: number, } | { "kind": "capsule",
  /**
   * Radius of cylinder and caps.
   */
  radius_m: number,
  /**
   * Half the length of the cylinder, caps not counted.
   */
  half_length_m: number, } | { "kind": "cylinder",
  /**
   * Radius.
   */
  radius_m: number,
  /**
   * Half its length.
   */
  half_length_m: number, } | { "kind": "ellipsoid",
  /**
   * Radii along x, y and z.
   */
  radii_m: [number, number, number], } | { "kind": "plane",
  /**
   * Half its edges along x and y; 0 means without end.
   */
  half_extents_m: [number, number], } | { "kind": "mesh",
  /**
   * Vertices, three coordinates each.
   */
  vertices: Array<number>,
  /**
   * Triangles, three vertex numbers each, counter-clockwise seen from outside.
   */
  triangles: Array<number>, };

/**
 * The world at one instant.
 */
export type State = {
  /**
   * Simulated time, in seconds.
   */
  time_secs: number,
  /**
   * Seconds of simulated time that pass in a second; 0 when nothing moves.
   */
  sim_speed: number,
  /**
   * World from base.
   */
  base: PosePlanar,
  /**
   * Every body that can move. A body not named stays where its scene put it, since a state
   * may be skipped by a slow reader.
   */
  body_poses: Array<BodyPose>,
  /**
   * The robot's joints.
   */
  joints: Array<JointPosition>, };

/**
 * Where a body is.
 */
export type BodyPose = {
  /**
   * The body's name in its scene.
   */
  name: string,
  /**
   * World from body.
   */
  pose: Pose, };

/**
 * Where a joint is.
 */
export type JointPosition = {
  /**
   * The joint's name.
   */
  name: string,
  /**
   * Radians of a hinge, metres of a slide.
   */
  position: number, };

/**
 * The way the base is about to take; no points when it stands.
 */
export type BasePath = {
  /**
   * Points `[x, y]` in the world, in metres, in driving order.
   */
  points: Array<[number, number]>, };

/**
 * An occupancy grid with the cell values and order of ROS `nav_msgs/OccupancyGrid`.
 *
 * Cells are ordered by rows along x, from the row at the origin upward in y. They travel as runs
 * `[value, count, value, count, ...]`, which makes a home's map some kilobytes.
 */
export type OccupancyMap = {
  /**
   * Cells along x.
   */
  width: number,
  /**
   * Cells along y.
   */
  height: number,
  /**
   * Edge of a cell, in metres.
   */
  resolution_m: number,
  /**
   * World from the outer corner of the first cell.
   */
  origin: PosePlanar,
  /**
   * The cells, as runs of a value (-1 unknown, 0 free to 100 occupied) and a count.
   */
  runs: Array<number>, };

/**
 * Object classes, objects, grounded navigation symbols and the topological graph between them.
 */
export type Aosm = {
  /**
   * Object classes.
   */
  classes: Array<ObjectClass>,
  /**
   * Objects of these classes in the home.
   */
  objects: Array<AosmObject>,
  /**
   * Navigation symbols grounded in this home.
   */
  regions: Array<NavigationRegion>,
  /**
   * Edges of the topological graph: regions between which the base can drive.
   */
  edges: Array<AosmEdge>, };

/**
 * A class of objects and what can be done with them.
 */
export type ObjectClass = {
  /**
   * Name.
   */
  name: string,
  /**
   * Names of its actions.
   */
  actions: Array<string>,
  /**
   * Where the class comes from.
   */
  provenance: Provenance, };

/**
 * Where an abstraction comes from.
 */
export type Provenance = "learned" | "taught" | "given";

/**
 * An object of the map.
 */
export type AosmObject = {
  /**
   * Name.
   */
  name: string,
  /**
   * Name of its class.
   */
  class: string,
  /**
   * World from object (Γ), as the robot believes it.
   */
  pose: Pose,
  /**
   * What is known of its state, in words, such as `on` or `in bin`; empty when nothing is.
   */
  state: string, };

/**
 * Where the base can stand to run an option: a navigation symbol grounded in this home.
 */
export type NavigationRegion = {
  /**
   * Name of the region, unique in the map.
   */
  name: string,
  /**
   * The option it is for, in words.
   */
  option: string,
  /**
   * The object the option acts on.
   */
  object: string,
  /**
   * Which of the page's colours it has; the page cycles through them when they run out.
   */
  colour_index: number,
  /**
   * Base poses `[x, y, yaw]` from which the option can start, in metres and radians.
   */
  poses: Array<[number, number, number]>, };

/**
 * A drivable way between two regions.
 */
export type AosmEdge = {
  /**
   * Name of the region it starts from.
   */
  from: string,
  /**
   * Name of the region it ends in.
   */
  to: string,
  /**
   * Length of the path, in metres.
   */
  length_m: number, };

/**
 * The steps from now or before to the goal, navigation interleaved. A new plan replaces it.
 */
export type Plan = {
  /**
   * How often the robot has planned anew in this job.
   */
  replans: number,
  /**
   * The steps, in order.
   */
  steps: Array<PlanStep>, };

/**
 * One step.
 */
export type PlanStep = {
  /**
   * Place in the plan, from 0.
   */
  index: number,
  /**
   * Driving or acting.
   */
  kind: StepKind,
  /**
   * Name of the action.
   */
  action: string,
  /**
   * What it is done with.
   */
  args: Array<string>,
  /**
   * How it stands.
   */
  state: StepState,
  /**
   * How often it was tried.
   */
  attempts: number,
  /**
   * Why it failed, was tried again or was skipped: one sentence; empty when there is nothing to
   * say.
   */
  reason: string, };

/**
 * What a step moves.
 */
export type StepKind = "navigate" | "manipulate";

/**
 * How a step stands.
 */
export type StepState = "pending" | "running" | "done" | "failed" | "skipped";

/**
 * What the robot is at.
 */
export type Status = {
  /**
   * The goal, in words.
   */
  goal: string,
  /**
   * What is being done for it.
   */
  activity: Activity,
  /**
   * Whether the job waits for a `resume`.
   */
  paused: boolean,
  /**
   * Whether a person drives: the job takes `drive` and `drive_done`.
   */
  takes_driving: boolean, };

/**
 * Phase of a job.
 */
export type Activity = "starting" | "exploring" | "planning" | "acting" | "stopped" | "finished";

/**
 * Something that happened, for people to read.
 */
export type Event = {
  /**
   * How much it matters.
   */
  level: EventLevel,
  /**
   * One sentence.
   */
  text: string,
  /**
   * Simulated time at which it happened, in seconds.
   */
  time_secs: number, };

/**
 * How much an event matters.
 */
export type EventLevel = "info" | "warning" | "error";

/**
 * The job is over.
 */
export type Done = {
  /**
   * The judge's word on whether the goal is achieved.
   */
  achieved: boolean,
  /**
   * What was done, and why not when it was not: a sentence or two.
   */
  summary: string, };

/**
 * The trainings there are: those under way first, then the latest begun. A later message replaces it.
 */
export type Trainings = {
  /**
   * The trainings.
   */
  trainings: Array<Training>, };

/**
 * How far a skill is learned.
 */
export type Training = {
  /**
   * Name of its folder, unique among the trainings.
   */
  name: string,
  /**
   * Name of the task.
   */
  task: string,
  /**
   * Name of the setting, such as `cip`.
   */
  ablation: string,
  /**
   * Seed of all that is random, in digits: a page's numbers are exact only up to 2^53.
   */
  seed: string,
  /**
   * Whether it went on within the last seconds.
   */
  running: boolean,
  /**
   * Training episodes lived through.
   */
  episodes: number,
  /**
   * Steps in them.
   */
  env_steps: number,
  /**
   * Those of them in which a joint came near its limit.
   */
  violations: number,
  /**
   * Share of successes in the last 20 of them, 0 to 1; nothing before the first.
   */
  recent_success_rate: number | null,
  /**
   * Its evaluations by episode. Of very many, evenly chosen ones and the last.
   */
  evaluations: Array<Evaluation>, };

/**
 * What rollouts of the policy said that nothing was learned from.
 */
export type Evaluation = {
  /**
   * Training episodes before it.
   */
  episode: number,
  /**
   * Share of rollouts that succeeded, 0 to 1.
   */
  success_rate: number,
  /**
   * Share of rollouts in which a joint came near its limit, 0 to 1.
   */
  violation_rate: number,
  /**
   * Median over the rollouts of the largest contact force on a finger, in newtons.
   */
  peak_force_n: number,
  /**
   * Median time of the rollouts that succeeded, in seconds; nothing when none did.
   */
  time_to_success_secs: number | null, };

/**
 * A home as it can be taught: replaced as a whole after each edit.
 */
export type Teaching = {
  /**
   * Why no edits are taken now; empty when they are.
   */
  closed: string,
  /**
   * Classes of the home, by name.
   */
  classes: Array<TaughtClass>,
  /**
   * Objects of the home, by name.
   */
  objects: Array<TaughtObject>,
  /**
   * Classes that are not in the home and can be taken into it as they are.
   */
  catalogue: Array<CatalogueClass>,
  /**
   * The edit that `Edit::Undo` would undo, in words.
   */
  undo: string | null,
  /**
   * The edit that `Edit::Redo` would do again, in words.
   */
  redo: string | null,
  /**
   * The latest entries of the journal, the newest first.
   */
  history: Array<HistoryEntry>,
  /**
   * Widest opening of the robot's gripper, in metres.
   */
  aperture_max_m: number, };

/**
 * An entry of the home's journal.
 */
export type HistoryEntry = {
  /**
   * Its number.
   */
  entry: number,
  /**
   * What was done, in words.
   */
  what: string,
  /**
   * Who did it.
   */
  author: string, };

/**
 * A class that can be taken into the home.
 */
export type CatalogueClass = {
  /**
   * Its name.
   */
  name: string,
  /**
   * One sentence for people.
   */
  description: string, };

/**
 * A class, all of it given in its frame Λ.
 */
export type TaughtClass = {
  /**
   * Name.
   */
  name: string,
  /**
   * One sentence for people.
   */
  description: string,
  /**
   * Where it comes from.
   */
  provenance: Provenance,
  /**
   * Number of the journal's entry that last changed it.
   */
  revision: number,
  /**
   * Whether its objects can be carried away.
   */
  movable: boolean,
  /**
   * The shape it was made of; nothing when its model is another one.
   */
  form: Form | null,
  /**
   * What it looks like.
   */
  parts: Array<ClassPart>,
  /**
   * Its joints.
   */
  joints: Array<ClassJoint>,
  /**
   * Named intervals of its joints.
   */
  states: Array<ClassState>,
  /**
   * Ways to hold it.
   */
  grasps: Array<Grasp>,
  /**
   * What can be done with it.
   */
  actions: Array<Action>, };

/**
 * Shapes of a class that move together.
 */
export type ClassPart = {
  /**
   * Joints that move them, the outermost first.
   */
  joints: Array<string>,
  /**
   * The shapes with all joints at zero; their poses are in Λ.
   */
  shapes: Array<Shape>, };

/**
 * A joint of a class.
 */
export type ClassJoint = {
  /**
   * Name.
   */
  name: string,
  /**
   * How it moves.
   */
  kind: JointKind,
  /**
   * Direction of its axis in Λ.
   */
  axis: [number, number, number],
  /**
   * A point on its axis in Λ, in metres.
   */
  origin: [number, number, number],
  /**
   * Lower and upper limit, in radians or metres.
   */
  range: [number, number], };

/**
 * Kinds of joints.
 */
export type JointKind = "revolute" | "prismatic";

/**
 * A named interval of a joint.
 */
export type ClassState = {
  /**
   * Name.
   */
  name: string,
  /**
   * The joint.
   */
  joint: string,
  /**
   * Lower and upper end, in radians or metres.
   */
  range: [number, number], };

/**
 * An object of the home.
 */
export type TaughtObject = {
  /**
   * Name.
   */
  name: string,
  /**
   * Its class.
   */
  class: string,
  /**
   * World from object (Γ).
   */
  pose: Pose,
  /**
   * How it got into the map.
   */
  provenance: Provenance,
  /**
   * Number of the journal's entry that last changed it.
   */
  revision: number,
  /**
   * Which of the page's colours it has for good, whatever objects come and go.
   */
  colour_index: number, };

/**
 * A shape that a class can be made of. Λ is in the middle of its foot, z up.
 */
export type Form = { "kind": "box",
  /**
   * Its edges along x, y and z, in metres.
   */
  size_m: [number, number, number], } | { "kind": "cylinder",
  /**
   * Diameter, in metres.
   */
  diameter_m: number,
  /**
   * Height, in metres.
   */
  height_m: number, };

/**
 * A way to hold an object: attribute "grasp".
 */
export type Grasp = {
  /**
   * Name within the class.
   */
  name: string,
  /**
   * Λ from tool, the joints at zero: z is the direction of approach, x that in which the fingers close.
   */
  object_from_tool: Pose,
  /**
   * Opening of the gripper before it closes, in metres.
   */
  aperture_m: number,
  /**
   * Part of the model that is held; the whole if absent.
   */
  link: string | null,
  /**
   * Whether it may be turned about Λ's z axis by any angle.
   */
  yaw_symmetric: boolean,
  /**
   * Where it comes from. In an edit it counts for nothing: what a person puts is taught.
   */
  provenance: Provenance, };

/**
 * Something that can be done with an object of a class.
 */
export type Action = {
  /**
   * Name within the class.
   */
  name: string,
  /**
   * Grasp to do it with; any of the class if absent.
   */
  grasp: string | null,
  /**
   * What moves.
   */
  motion: ActionMotion,
  /**
   * Where the base may stand for it; a default if absent.
   */
  approach: Approach | null,
  /**
   * Where it comes from. In an edit it counts for nothing: what a person puts is taught.
   */
  provenance: Provenance, };

/**
 * What moves in an action.
 */
export type ActionMotion = { "kind": "joint",
  /**
   * The joint.
   */
  joint: string,
  /**
   * Position where the action begins; anywhere if absent.
   */
  initiation: number | null,
  /**
   * Position where it ends.
   */
  termination: number,
  /**
   * Whether fingers hold it or push it.
   */
  contact: Contact,
  /**
   * Name of the state that holds afterwards. Where the class has no such state, one is made about the termination.
   */
  effect: string, } | { "kind": "put_into",
  /**
   * Class of the other.
   */
  class: string,
  /**
   * Λ of the other from Λ of this one at release.
   */
  target_from_object: Pose,
  /**
   * Where the base may stand to put it there; a default if absent.
   */
  approach: Approach | null, };

/**
 * How the gripper touches what it moves.
 */
export type Contact = "grasp" | "push";

/**
 * Where the base may stand.
 */
export type Approach = {
  /**
   * Nearest and farthest distance of the base from Λ on the floor, in metres.
   */
  distance_m: [number, number], };

/**
 * A page's wish to change the home.
 */
export type EditRequest = {
  /**
   * A random name of the page's choice, at most `EDIT_ID_CHARS_MAX` characters. A request that was
   * accepted and comes again, as after a lost connection or a new start of the studio, is not applied again: it gets
   * the answer of the first.
   */
  id: string,
  /**
   * Revision of the class or object that the person saw when making the edit. If somebody has changed it since, the
   * edit is refused. Absent: the edit is applied to whatever there is.
   */
  base: number | null,
  /**
   * The change.
   */
  edit: Edit, };

/**
 * A change of a home.
 */
export type Edit = { "kind": "make_class",
  /**
   * Its name.
   */
  name: string,
  /**
   * The shape.
   */
  form: Form,
  /**
   * Whether its objects can be carried away.
   */
  movable: boolean, } | { "kind": "reshape_class",
  /**
   * The class.
   */
  name: string,
  /**
   * The new shape.
   */
  form: Form,
  /**
   * Whether its objects can be carried away.
   */
  movable: boolean, } | { "kind": "take_class",
  /**
   * Its name.
   */
  name: string, } | { "kind": "remove_class",
  /**
   * Its name.
   */
  name: string, } | { "kind": "put_grasp",
  /**
   * The class.
   */
  class: string,
  /**
   * The grasp.
   */
  grasp: Grasp, } | { "kind": "remove_grasp",
  /**
   * The class.
   */
  class: string,
  /**
   * Name of the grasp.
   */
  name: string, } | { "kind": "put_action",
  /**
   * The class.
   */
  class: string,
  /**
   * The action.
   */
  action: Action, } | { "kind": "remove_action",
  /**
   * The class.
   */
  class: string,
  /**
   * Name of the action.
   */
  name: string, } | { "kind": "add_object",
  /**
   * The class.
   */
  class: string,
  /**
   * World from object (Γ).
   */
  pose: Pose, } | { "kind": "move_object",
  /**
   * Its name.
   */
  name: string,
  /**
   * World from object (Γ).
   */
  pose: Pose, } | { "kind": "rename_object",
  /**
   * Its name.
   */
  name: string,
  /**
   * The new one.
   */
  to: string, } | { "kind": "remove_object",
  /**
   * Its name.
   */
  name: string, } | { "kind": "undo" } | { "kind": "redo" };

/**
 * What became of an `EditRequest`.
 */
export type EditAnswer = {
  /**
   * The request's id.
   */
  id: string,
  /**
   * What became of it.
   */
  outcome: EditOutcome, };

/**
 * What became of an edit.
 */
export type EditOutcome = { "kind": "accepted",
  /**
   * Number of its entry; nothing when it changed nothing.
   */
  entry: number | null,
  /**
   * Name of the class or object that was made or changed; of an undone or redone edit, its words.
   */
  what: string, } | { "kind": "refused",
  /**
   * Why: the thing, what was found and what was wanted.
   */
  reason: string, };
