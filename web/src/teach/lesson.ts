// Where a person is in teaching, and what is not saved of it yet. Pure: no page, no picture.

import type {
  Action,
  ActionMotion,
  Form,
  Grasp,
  Pose,
  TaughtClass,
  TaughtObject,
  Teaching,
} from "../protocol";

/** A step of teaching. All but the first two are about an object, at which its class is taught. */
export type Lesson =
  | { readonly step: "overview" }
  | { readonly step: "class" }
  | { readonly step: "place" | "grasps" | "actions"; readonly object: string }
  /** `name` is that of the grasp or action that is changed; empty for a new one. */
  | { readonly step: "grasp" | "action"; readonly object: string; readonly name: string };

export interface Draft {
  /** World from object while it is dragged. */
  readonly pose: Pose | null;
  readonly grasp: Grasp | null;
  readonly action: Action | null;
}

export const OVERVIEW: Lesson = { step: "overview" };
export const NO_DRAFT: Draft = { pose: null, grasp: null, action: null };

/** The steps in the order in which a person goes through them. */
export const STEPS = ["class", "place", "grasps", "actions"] as const;

/** Which of the steps a lesson belongs to; -1 for none. */
export function stepIndex(lesson: Lesson): number {
  const step = lesson.step === "grasp" ? "grasps" : lesson.step === "action" ? "actions" : lesson.step;
  return STEPS.findIndex((other) => other === step);
}

export interface Subject {
  readonly object: TaughtObject;
  readonly of: TaughtClass;
}

/** The object that a lesson is about, and its class; null when it is about none that is there. */
export function subjectOf(lesson: Lesson, teaching: Teaching | null): Subject | null {
  if (!("object" in lesson) || teaching === null) {
    return null;
  }
  const object = teaching.objects.find((other) => other.name === lesson.object);
  const of = teaching.classes.find((other) => other.name === object?.class);
  return object === undefined || of === undefined ? null : { object, of };
}

/** Whether what a lesson is about is still there: somebody may have taken it away. */
export function stillStands(lesson: Lesson, teaching: Teaching): boolean {
  const subject = subjectOf(lesson, teaching);
  if (subject === null) {
    return !("object" in lesson);
  }
  switch (lesson.step) {
    case "grasp":
      return lesson.name === "" || subject.of.grasps.some(({ name }) => name === lesson.name);
    case "action":
      return lesson.name === "" || subject.of.actions.some(({ name }) => name === lesson.name);
    default:
      return true;
  }
}

/** A name as plans and files can carry it: `Green bottle!` becomes `green_bottle`. */
export function plainName(text: string): string {
  return text
    .trim()
    .toLowerCase()
    .replaceAll(/[^a-z0-9_-]+/g, "_")
    .replaceAll(/^[^a-z]+|_+$/g, "");
}

/** The first of `name`, `name_2`, `name_3`, ... that is not taken. */
export function freeName(name: string, taken: readonly string[]): string {
  let free = name;
  for (let number = 2; taken.includes(free); number++) {
    free = `${name}_${number}`;
  }
  return free;
}

/** Size of a class in Λ, metres: how far it reaches from its middle on the floor, and how high. */
export interface Size {
  readonly radius: number;
  readonly height: number;
}

export function sizeOfForm(form: Form): Size {
  return form.kind === "box"
    ? { radius: 0.5 * Math.min(form.size_m[0], form.size_m[1]), height: form.size_m[2] }
    : { radius: 0.5 * form.diameter_m, height: form.height_m };
}

/** Room on both sides of what the fingers close on, metres. */
const FINGER_ROOM_M = 0.015;

/** Where a hand may begin: level from the side at mid height, or from above. */
export function firstGrasp(from: "side" | "above", of: TaughtClass, size: Size, widestM: number): Grasp {
  const taken = of.grasps.map(({ name }) => name);
  const aperture = Math.min(widestM, 2 * size.radius + 2 * FINGER_ROOM_M);
  const pose: Pose =
    from === "side"
      ? // The tool's z along Λ's x, its x along Λ's y: fingers close level.
        { position: [0, 0, 0.45 * size.height], orientation_xyzw: [0.5, 0.5, 0.5, 0.5] }
      : // Straight down, closing along Λ's x.
        { position: [0, 0, 0.85 * size.height], orientation_xyzw: [1, 0, 0, 0] };
  return {
    name: freeName(from, taken),
    object_from_tool: pose,
    aperture_m: Math.round(aperture * 1000) / 1000,
    link: null,
    yaw_symmetric: of.form?.kind === "cylinder",
    provenance: "taught",
  };
}

/**
 * What a thing is called when an action of this effect ends with a joint at a position: the state that is known there.
 * Where none is, the name stays that a person gave it, but not that of a state elsewhere.
 */
export function effectAt(of: TaughtClass, joint: string, position: number, effect: string): string {
  const [from, to] = of.joints.find(({ name }) => name === joint)?.range ?? [position, position];
  // Pushing goes a little beyond the stop: the joint does not.
  const at = Math.min(Math.max(position, from), to);
  const there = of.states.find((state) => state.joint === joint && state.range[0] <= at && at <= state.range[1]);
  return there?.name ?? (of.states.some(({ name }) => name === effect) ? "" : effect);
}

/** How high above its rim a thing is let go over a container, metres. */
const RELEASE_ABOVE_M = 0.08;
/** Distances at which an arm of common length reaches over the base's edge, metres. */
const NEAR_FAR_M: [number, number] = [0.55, 0.85];

/** The first of what can be done with a class: put it into something, or move its first joint. */
export function firstAction(kind: ActionMotion["kind"], of: TaughtClass, target: TaughtClass | null, targetSize: Size): Action {
  const taken = of.actions.map(({ name }) => name);
  const joint = of.joints[0];
  const motion: ActionMotion =
    kind === "joint" && joint !== undefined
      ? {
          kind,
          joint: joint.name,
          initiation: joint.range[0],
          termination: joint.range[1],
          contact: "grasp",
          effect: effectAt(of, joint.name, joint.range[1], ""),
        }
      : { kind: "put_into", class: target?.name ?? "", ...releaseOver(targetSize) };
  const name = kind === "joint" ? "" : target === null ? "" : freeName(`put_in_${target.name}`, taken);
  return { name, grasp: null, motion, approach: { distance_m: NEAR_FAR_M }, provenance: "taught" };
}

/** Where a thing is let go over a container of this size. */
export function releaseOver(size: Size): Pick<Extract<ActionMotion, { kind: "put_into" }>, "target_from_object" | "approach"> {
  const height = Math.round((size.height + RELEASE_ABOVE_M) * 1000) / 1000;
  return {
    target_from_object: { position: [0, 0, height], orientation_xyzw: [0, 0, 0, 1] },
    approach: { distance_m: [NEAR_FAR_M[0] + 0.07, NEAR_FAR_M[1] + 0.03] },
  };
}

