// What a person does about actions: begin one, change it, save it, forget it.

import type { Action, ActionMotion, TaughtClass } from "../protocol";
import { sizeOf } from "../view/class_model";
import { type Desk, goTo, isAt, withSubject } from "./desk";
import { effectAt, firstAction, releaseOver, type Subject } from "./lesson";

export type JointMotion = Extract<ActionMotion, { kind: "joint" }>;
export type PutInto = Extract<ActionMotion, { kind: "put_into" }>;

/** Where the base may stand if nobody says, metres. */
export const APPROACH_M: readonly [number, number] = [0.8, 1.25];

/** Classes that a thing can be put into: those of the home but its own. */
export function targets(desk: Desk, of: TaughtClass): TaughtClass[] {
  return (desk.store.get("teaching")?.classes ?? []).filter((other) => other.name !== of.name && !other.movable);
}

/** Goes to the step of a new action. */
export function newAction(desk: Desk, kind: ActionMotion["kind"]): void {
  withSubject(desk, ({ object, of }) => {
    const [target] = targets(desk, of);
    const action = firstAction(kind, of, target ?? null, sizeOf(target ?? { parts: [] }));
    desk.store.learn({ step: "action", object: object.name, name: "" }, { pose: null, grasp: null, action });
  });
}

/** Goes to the step of an action that is there. */
export function openAction(desk: Desk, { object }: Subject, action: Action): void {
  desk.store.learn({ step: "action", object: object.name, name: action.name }, { pose: null, grasp: null, action });
}

export function changeAction(desk: Desk, changed: Partial<Action>): void {
  const { action } = desk.store.get("draft");
  if (action !== null) {
    desk.store.drafted({ action: { ...action, ...changed } });
  }
}

/** Changes an action that puts a thing into another. */
export function changePut(desk: Desk, changed: Partial<PutInto>): void {
  const motion = desk.store.get("draft").action?.motion;
  if (motion?.kind === "put_into") {
    changeAction(desk, { motion: { ...motion, ...changed } });
  }
}

/** Chooses into what a thing goes. */
export function choosePut(desk: Desk, { of }: Subject, name: string): void {
  const target = targets(desk, of).find((other) => other.name === name);
  if (target !== undefined) {
    changePut(desk, { class: name, ...releaseOver(sizeOf(target)) });
  }
}

/** Changes an action with a joint; what it brings about is called as it is known there. */
export function changeJoint(desk: Desk, of: TaughtClass, changed: Partial<JointMotion>): void {
  const motion = desk.store.get("draft").action?.motion;
  if (motion?.kind === "joint") {
    const next = { ...motion, ...changed };
    const effect = "effect" in changed ? next.effect : effectAt(of, next.joint, next.termination, next.effect);
    changeAction(desk, { motion: { ...next, effect } });
  }
}

/** Chooses the part that moves. */
export function chooseJoint(desk: Desk, of: TaughtClass, name: string): void {
  const joint = of.joints.find((other) => other.name === name);
  if (joint !== undefined) {
    changeJoint(desk, of, { joint: name, initiation: joint.range[0], termination: joint.range[1] });
  }
}

export function canSaveAction(desk: Desk): boolean {
  const { action } = desk.store.get("draft");
  if (action === null || action.name === "") {
    return false;
  }
  const { motion } = action;
  return motion.kind === "joint" ? motion.effect !== "" : motion.class !== "";
}

export async function saveAction(desk: Desk, { of }: Subject): Promise<void> {
  const lesson = desk.store.get("lesson");
  const { action } = desk.store.get("draft");
  if (action === null) {
    return;
  }
  const outcome = await desk.edits.ask({ kind: "put_action", class: of.name, action });
  if (outcome.kind === "accepted" && isAt(desk, lesson)) {
    goTo(desk, "actions");
  }
}

export function forgetAction(desk: Desk, { of }: Subject, name: string): void {
  void desk.edits.ask({ kind: "remove_action", class: of.name, name });
}
