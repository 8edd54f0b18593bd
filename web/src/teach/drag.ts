// What a drag means, whatever hand does it: a mouse on the gizmo, a controller's ray, two fingers.
//
// A thing is dragged in the frame in which people see its numbers: the world for Γ, Λ for a gripper, the frame of what a
// thing is put into for a release.

import { Quaternion, Vector3 } from "three";

import { composed, IDENTITY, inverted } from "../frames";
import type { ClassJoint, Pose, Teaching } from "../protocol";
import type { Store } from "../store";
import { type Draft, type Lesson, subjectOf } from "./lesson";
import { type Grid, GRID, settled } from "./settle";

/** What a hand would move now. */
export interface Held {
  /** World from the frame in which it is given. */
  readonly worldFromBase: Pose;
  /** It in that frame. */
  readonly baseFromHeld: Pose;
  readonly grid: Grid;
}

/** Where the first object of a class stands: the one that a release is shown at. */
export function targetOf(name: string, teaching: Teaching | null): Pose | null {
  return teaching?.objects.find((object) => object.class === name)?.pose ?? null;
}

/** What the step is about, if it is something to drag as a whole. */
export function heldOf(lesson: Lesson, draft: Draft, teaching: Teaching | null): Held | null {
  const subject = subjectOf(lesson, teaching);
  if (subject === null) {
    return null;
  }
  const { pose } = subject.object;
  if (lesson.step === "place") {
    return { worldFromBase: IDENTITY, baseFromHeld: draft.pose ?? pose, grid: GRID.home };
  }
  if (lesson.step === "grasp" && draft.grasp !== null) {
    return { worldFromBase: pose, baseFromHeld: draft.grasp.object_from_tool, grid: GRID.hand };
  }
  if (lesson.step === "action" && draft.action?.motion.kind === "put_into") {
    const { motion } = draft.action;
    const target = targetOf(motion.class, teaching);
    return target && { worldFromBase: target, baseFromHeld: motion.target_from_object, grid: GRID.hand };
  }
  return null;
}

/** World from what is held. */
export function worldFromHeld({ worldFromBase, baseFromHeld }: Held): Pose {
  return composed(worldFromBase, baseFromHeld);
}

/**
 * Takes what is held from where it was when the drag began to where the hand wants it: the draft follows, slowed down and
 * drawn to the grid. World from what is held then; null if there is nothing.
 */
export function dragTo(store: Store, start: Pose, wanted: Pose): Pose | null {
  const draft = store.get("draft");
  const held = heldOf(store.get("lesson"), draft, store.get("teaching"));
  if (held === null) {
    return null;
  }
  const inverse = inverted(held.worldFromBase);
  const pose = settled(composed(inverse, start), composed(inverse, wanted), store.get("hand"), held.grid);
  if (draft.action?.motion.kind === "put_into") {
    store.drafted({ action: { ...draft.action, motion: { ...draft.action.motion, target_from_object: pose } } });
  } else if (draft.grasp !== null) {
    store.drafted({ grasp: { ...draft.grasp, object_from_tool: pose } });
  } else {
    store.drafted({ pose });
  }
  return composed(held.worldFromBase, pose);
}

/** Nearer than this to its axis, a hand does not say how far a joint is turned, metres. */
const AXIS_M = 0.005;

type Point = readonly [number, number, number];

/** How far a joint goes, in radians or metres, when a point of its part is drawn from one point to another (in Λ). */
export function jointTravel(joint: ClassJoint, from: Point, to: Point): number {
  const axis = new Vector3(...joint.axis).normalize();
  if (joint.kind === "prismatic") {
    return new Vector3(...to).sub(new Vector3(...from)).dot(axis);
  }
  const arm = (point: Point): Vector3 =>
    new Vector3(...point).sub(new Vector3(...joint.origin)).projectOnPlane(axis);
  const [before, after] = [arm(from), arm(to)];
  if (before.length() < AXIS_M || after.length() < AXIS_M) {
    return 0;
  }
  return Math.atan2(before.clone().cross(after).dot(axis), before.dot(after));
}

/** Steps to which joints are drawn: radians and metres. */
const JOINT_STEP = { revolute: Math.PI / 36, prismatic: 0.005 } as const;

/** Where a joint goes that was at `start` when the drag began. Its ends are no steps of a grid, but stops. */
export function jointDragged(joint: ClassJoint, start: number, travel: number, hand: { snap: boolean; speed: number }): number {
  const [low, high] = joint.range;
  const free = start + hand.speed * travel;
  if (free <= low || free >= high) {
    return Math.min(Math.max(free, low), high);
  }
  const step = JOINT_STEP[joint.kind];
  const drawn = hand.snap ? Math.round(free / step) * step : free;
  return Math.min(Math.max(drawn, low), high);
}

/** The share of a turn that is about the upright: things stand as they stood. In the world (z up). */
export function uprightTurn(turn: Quaternion): Quaternion {
  const length = Math.hypot(turn.z, turn.w);
  return length < 1e-9 ? new Quaternion() : new Quaternion(0, 0, turn.z / length, turn.w / length);
}
