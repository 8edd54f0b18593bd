// Generated from crates/protocol; do not edit. To bring it up to date:
//   cargo run -p factotum-protocol --example codegen

export const VERSION = 1;

/**
 * From studio to page.
 */
export type ServerMessage = { "type": "hello" } & Hello | { "type": "scene" } & Scene | { "type": "state" } & State | { "type": "map" } & OccupancyMap | { "type": "aosm" } & Aosm | { "type": "plan" } & Plan | { "type": "base_path" } & BasePath | { "type": "status" } & Status | { "type": "event" } & Event | { "type": "done" } & Done | { "type": "trainings" } & Trainings;

/**
 * From page to studio.
 */
export type ClientMessage = { "type": "pause" } | { "type": "resume" } | { "type": "stop" } | { "type": "drive" } & Drive | { "type": "drive_done" };

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
  session: string, };

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
