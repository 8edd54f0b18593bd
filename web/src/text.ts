// Every word a person reads on this page.

import type { Push } from "./drive_pad";
import type { Activity, Evaluation, EventLevel, PlanStep, Role, StepState, Training } from "./protocol";
import type { Connection, Headset } from "./store";
import type { Alignment, AlignedBy } from "./xr/map_from_xr";
import type { Mode, Offer } from "./xr/offer";

export const TEXT = {
  name: "Factotum",
  goal: "Goal",
  noGoal: "Waiting for a job",
  plan: "Plan",
  planEmpty: "No plan yet. The robot first looks around its home.",
  events: "What happened",
  eventsEmpty: "Nothing yet.",
  legend: "Where it can stand",
  legendEmpty: "Regions appear once the robot knows where its skills work.",
  pause: "Pause",
  resume: "Go on",
  stop: "Stop",
  stopTitle: "Stop the job?",
  stopBody: "The robot stops where it is and the job ends. It cannot be taken up again from here.",
  stopYes: "Stop it",
  stopNo: "Let it go on",
  follow: "Follow",
  map: "Map",
  regions: "Regions",
  labels: "Labels",
  viewTools: "What to show",
  jobTools: "Job",
  achieved: "Achieved",
  notAchieved: "Not achieved",
  paused: "Paused",
  time: "Robot time",
  speed: "Speed",
  scene: "Live view of the robot in its home. Arrow keys turn, plus and minus zoom.",
  noWebGl: "This browser cannot draw in 3-D (no WebGL 2). Plan and events work all the same.",
  drive: "Drive by hand",
  driveHint: "Hold to drive. Arrow keys do too.",
  driveDone: "Done",
  learn: "Learn",
  success: "success",
  violation: "near a joint limit",
  learning: "learning",
  atRest: "at rest",
  figures: "Figures",
  figuresEmpty: "Not evaluated yet.",
  driving: "drive",
  acting: "act",
} as const;

/** Words of teaching. Each step says what is being told of the thing, and what comes next. */
export const TEACH = {
  title: "Teach",
  undo: "Undo",
  redo: "Do again",
  nothingToUndo: "Nothing to undo",
  nothingToRedo: "Nothing to do again",
  history: "What was taught",
  saving: "Saving",
  refused: "Not done",
  mayNot: "This page was opened to look. A link to teach is shown where the studio was started.",
  steps: { class: "What", place: "Where", grasps: "Hold", actions: "Do" },
  back: "Back",
  next: "Next",
  finish: "Finish",
  save: "Save",
  cancel: "Leave it",
  change: "Change",
  forget: "Forget",
  remove: "Take it out of the map",
  rename: "Rename",
  name: "Name",

  overviewTitle: "Your home",
  overview: "Choose a thing to change what the robot knows of it, or teach it a new one.",
  overviewEmpty: "The robot knows of no thing in this home yet. Teach it the first one.",
  teachNew: "Teach a new thing",

  classTitle: "What is it?",
  classBody:
    "Choose what kind of thing it is. All that you teach belongs to the kind, and works on every thing of it. " +
    "Next you put it where it stands.",
  known: "Kinds in this home",
  catalogue: "Kinds that come with the robot",
  make: "A new kind, made of a shape",
  makeIt: "Make it",
  shape: "Shape",
  cylinder: "Cylinder",
  box: "Box",
  diameter: "Diameter",
  height: "Height",
  widthX: "Length (x)",
  widthY: "Width (y)",
  movable: "The robot can carry it",
  placed: (name: string) => `Put a ${words(name)} into the map`,

  placeTitle: (name: string) => `Where is ${words(name)}?`,
  placeBody:
    "Drag its model over the real thing: arrows move it, rings turn it. Or write where it stands. " +
    "Next you show how to hold it.",
  onFloor: "Put it on the floor",
  resize: "Size, cm",
  move: "Move",
  turn: "Turn",
  snap: "Snap to floor and grid",
  speed: "Speed of the hand",
  drag: "How to drag",
  position: "Position, cm",
  orientation: "Turned, degrees",
  axes: ["x", "y", "z"],
  turns: ["roll", "pitch", "yaw"],

  graspsTitle: (kind: string) => `How is a ${words(kind)} held?`,
  graspsBody: "The ways in which the gripper can take it. More than one lets the robot choose. Next you say what to do with it.",
  graspsEmpty: "It knows of none yet.",
  addGrasp: "Show a way to hold it",
  graspTitle: (kind: string) => `Hold the ${words(kind)}`,
  graspBody:
    "Drag the gripper to where it is to close: its fingers close along x, it comes along z. " +
    "What you show counts for every thing of this kind. Save it, then show another or go on.",
  fromSide: "Begin at its side",
  fromAbove: "Begin above it",
  opening: "Opening, cm",
  symmetric: "Just as good from all sides",

  actionsTitle: (kind: string) => `What can be done with a ${words(kind)}?`,
  actionsBody: "What the robot may plan with. When all is there, you are done.",
  actionsEmpty: "Nothing yet.",
  addPutInto: "Put it into something",
  addJoint: "Move a part of it",
  actionTitle: (kind: string) => `Do something with a ${words(kind)}`,
  putIntoBody:
    "Name it, choose into what kind of thing it goes, and drag the pale copy to where the robot lets it go. " +
    "Then save it: the robot can plan with it at once.",
  jointBody:
    "Name it, choose the part that moves, and slide it to where the action begins and to where it ends: " +
    "the two pale copies show both. Then save it.",
  into: "Into",
  noTarget: "There is no such thing in the map yet, so the place is given from its middle.",
  noContainer: "Teach the thing that it goes into first: a bin, for example.",
  part: "Part that moves",
  begins: (turns: boolean) => `Begins at, ${turns ? "degrees" : "cm"}`,
  ends: (turns: boolean) => `Ends at, ${turns ? "degrees" : "cm"}`,
  contact: "The gripper",
  grasps: "holds it",
  pushes: "pushes it",
  effect: "Then it is",
  withGrasp: "Held by",
  anyGrasp: "any way to hold it",
  nearest: "Base at least, cm away",
  farthest: "and at most",
} as const;

/** Words of teaching in a headset, where a thing is pointed at rather than written about. */
export const HEADSET = {
  title: "Headset",
  enter: { "immersive-ar": "Teach in the room (AR)", "immersive-vr": "Teach in the map (VR)" },
  leave: "Leave",
  arBody: "You see your room, and in it what the robot knows. First put the virtual robot over the real one.",
  vrBody: "You stand in the robot's map. Draw the floor to you to go elsewhere.",

  placeBody:
    "Point at its model, hold the trigger or pinch, and draw it over the real thing. Next you show how to hold it.",
  graspBody:
    "Draw the gripper to where it is to close: fingers close along its width, it comes along its length. Then save it.",
  putIntoBody: "Choose into what it goes, and draw the pale copy to where the robot lets it go. Then save it.",
  jointBody: "Draw the pale part to where the action ends, and the other to where it begins. Then save it.",
  alignTitle: "Where is the robot?",
  alignBody:
    "Draw the virtual robot over the real one, so that it looks the same way: all that was taught moves with it. Then press Done.",
  originBody:
    "No robot is connected. The virtual one stands at the map's origin: draw it over where the robot was when it began the map.",

  align: "Place robot",
  done: "Done",
  speed: (share: string) => `Speed ${share}`,
  snap: "Snap",
  less: (what: string) => `${what} −`,
  more: (what: string) => `${what} +`,
  valueOf: (what: string, value: string) => `${what} ${value}`,
  forget: (what: string) => `Forget ${what}`,
  earlier: "‹ Earlier",
  later: "More ›",
  opening: "Opening",
  symmetric: "From all sides",
  begins: "Begins",
  ends: "Ends",
  trail: (at: number, of: number, step: string) => `${at} of ${of}: ${step}`,
  rename: "Name it",
  naming: (what: string) => `${what}: what is it called?`,
  space: "space",
  erase: "⌫",
  clear: "Clear",
  length: "Length",
  width: "Width",
  carried: "The robot can carry it",
  cancel: "Leave it",
  distances: "How far away the base stands is set on the page.",
  lost: "The headset has lost where it is: look around slowly.",
  watchOnly: "There is nothing to be taught while a robot is at work.",
} as const;

/** Why there is no headset to enter, and what would help. */
export function offerText(offer: Offer): string {
  if (offer.kind === "asking") {
    return "Looking for a headset.";
  }
  if (offer.kind === "offered") {
    return offer.mode === "immersive-ar" ? HEADSET.arBody : HEADSET.vrBody;
  }
  switch (offer.why) {
    case "insecure":
      return "This page is not secure, and browsers open headsets only to secure pages. Open it on this computer, or over https.";
    case "no_webxr":
      return "This browser knows nothing of headsets (no WebXR). Open the page in the headset's own browser.";
    case "no_headset":
      return "This browser finds no headset, neither for AR nor for VR. Teach by mouse or keys, or open the page in a headset.";
  }
}

/** How the headset is worn, or why it is not. */
export function headsetText({ offer, worn, lost, problem }: Headset): string {
  if (problem !== "") {
    return `The headset did not open: ${problem}`;
  }
  if (worn === null) {
    return offerText(offer);
  }
  const how: Record<Mode, string> = { "immersive-ar": "Worn, in the room (AR).", "immersive-vr": "Worn, in the map (VR)." };
  return lost ? HEADSET.lost : how[worn];
}

/** Where the headset's space lies, with the number of the alignment. */
export function alignmentText({ epoch, by }: Alignment): string {
  const how: Record<AlignedBy, string> = {
    placed: "as it began",
    moved: "moved by hand",
    robot: "by the robot",
    recentred: "the headset has moved its origin, and this has followed",
    lost: "the headset has lost its origin: place the robot again",
  };
  return `Alignment ${epoch}: ${how[by]}`;
}

/** A pose in a line. */
export function poseText(position: readonly number[], yawRad: number): string {
  const cm = position.map((value) => String(Math.round(1000 * value) / 10));
  return `x ${cm[0]}, y ${cm[1]}, z ${cm[2]} cm, turned ${Math.round((180 * yawRad) / Math.PI)}°`;
}

export function cmText(metres: number): string {
  return `${Math.round(1000 * metres) / 10} cm`;
}

export function degreesText(radians: number): string {
  return `${Math.round((180 * radians) / Math.PI)}°`;
}

export function activityText(activity: Activity): string {
  const words: Record<Activity, string> = {
    starting: "Starting",
    exploring: "Exploring",
    planning: "Planning",
    acting: "Acting",
    stopped: "Stopped",
    finished: "Finished",
  };
  return words[activity];
}

export function stepStateText(state: StepState): string {
  const words: Record<StepState, string> = {
    pending: "to do",
    running: "doing",
    done: "done",
    failed: "failed",
    skipped: "skipped",
  };
  return words[state];
}

export function levelText(level: EventLevel): string {
  const words: Record<EventLevel, string> = {
    info: "Note",
    warning: "Warning",
    error: "Error",
  };
  return words[level];
}

export function pushText(push: Push["name"]): string {
  const words: Record<Push["name"], string> = {
    forward: "Forward",
    back: "Back",
    left: "To the left",
    right: "To the right",
    turnLeft: "Turn left",
    turnRight: "Turn right",
  };
  return words[push];
}

/** An action's name as words: `turn_light-off` reads "turn light off". */
export function words(name: string): string {
  return name.replaceAll(/[_-]+/g, " ").trim();
}

export function stepTitle(step: PlanStep): string {
  return [words(step.action), ...step.args.map(words)].join(" ");
}

export function attemptsText(attempts: number): string {
  return `${attempts} tries`;
}

export function replansText(replans: number): string {
  return replans === 1 ? "planned anew once" : `planned anew ${replans} times`;
}

export function progressText(done: number, all: number): string {
  return `${done} of ${all}`;
}

export function countsText(classes: number, objects: number, edges: number): string {
  const many = (n: number, one: string, more: string): string => `${n} ${n === 1 ? one : more}`;
  return [
    many(classes, "class", "classes"),
    many(objects, "object", "objects"),
    many(edges, "way", "ways"),
  ].join(" · ");
}

export function posesText(n: number): string {
  return n === 1 ? "1 pose" : `${n} poses`;
}

export function percentText(share: number): string {
  return `${Math.round(100 * share)} %`;
}

export function episodesText(n: number): string {
  return n === 1 ? "1 episode" : `${n} episodes`;
}

/** What is learned: task, setting and seed. */
export function trainingText(training: Training): string {
  return `${words(training.task)} · ${training.ablation} · seed ${training.seed}`;
}

/** How far it is learned, by the episodes that are learned from. */
export function practiceText(training: Training): string {
  const parts = [episodesText(training.episodes), `${training.env_steps} steps`];
  if (training.recent_success_rate !== null) {
    const n = Math.min(training.episodes, 20);
    parts.push(`${percentText(training.recent_success_rate)} success in the last ${n}`);
  }
  parts.push(`${training.violations} near a joint limit`);
  return parts.join(" · ");
}

/** What a screen reader says of a learning curve; the table below it has every figure. */
export function curveText(evaluations: readonly Evaluation[]): string {
  const last = evaluations.at(-1);
  if (last === undefined) {
    return `Learning curve. ${TEXT.figuresEmpty}`;
  }
  const best = Math.max(...evaluations.map(({ success_rate }) => success_rate));
  const n = evaluations.length === 1 ? "1 evaluation" : `${evaluations.length} evaluations`;
  return (
    `Learning curve of ${n}. After ${episodesText(last.episode)}: ` +
    `success ${percentText(last.success_rate)}, near a joint limit ${percentText(last.violation_rate)}. ` +
    `Best success: ${percentText(best)}.`
  );
}

/** The heads of the table of evaluations. */
export const FIGURE_HEADS = ["Episode", "Success", "Near limit", "Peak force", "Time"] as const;

/** An evaluation as a row of that table. */
export function figureTexts(evaluation: Evaluation): readonly string[] {
  const secs = evaluation.time_to_success_secs;
  return [
    String(evaluation.episode),
    percentText(evaluation.success_rate),
    percentText(evaluation.violation_rate),
    `${Math.round(evaluation.peak_force_n)} N`,
    secs === null ? "–" : `${secs.toFixed(1)} s`,
  ];
}

/** Minutes and seconds, as a clock shows them. */
export function clockText(secs: number): string {
  const whole = Math.max(0, Math.floor(secs));
  const minutes = Math.floor(whole / 60);
  return `${minutes}:${String(whole % 60).padStart(2, "0")}`;
}

/** Times faster than real time. */
export function speedText(speed: number): string {
  return `${speed.toFixed(speed < 9.95 ? 1 : 0)}×`;
}

/** What a page may do, and whether another has the robot. */
export interface Standing {
  readonly role: Role;
  readonly isOwned: boolean;
}

export function connectionText(connection: Connection, jobIsOver: boolean, who: Standing): string {
  switch (connection.kind) {
    case "connecting":
      return "Connecting";
    case "open":
      return `${ROLE_WORDS[who.role]}${who.isOwned ? "; another page has the robot" : ""}`;
    case "lost":
      return jobIsOver
        ? "The run has ended; this is its last picture"
        : `Connection lost, trying again in ${connection.retryInSecs} s`;
    case "refused":
      return "This is another run now; open the address that it printed";
    case "mismatch":
      return "Page and program are of different versions; reload the page";
  }
}

const ROLE_WORDS: Record<Role, string> = {
  view: "Live, to look at",
  teach: "Live, to teach",
  execute: "Live",
};

/** What a screen reader says of the picture. */
export function sceneSummary(bodies: number, time: string): string {
  return `${TEXT.scene} ${bodies} bodies, robot time ${time}.`;
}
