// What a person does about ways to hold a thing: begin one, change it, save it, forget it.

import type { Grasp } from "../protocol";
import { sizeOf } from "../view/class_model";
import { type Desk, goTo, isAt, withSubject } from "./desk";
import { firstGrasp, type Subject } from "./lesson";

/** Opening of a gripper of which nothing is known, metres. */
const APERTURE_M = 0.1;

function begin(desk: Desk, { of }: Subject, from: "side" | "above"): Grasp {
  return firstGrasp(from, of, sizeOf(of), desk.store.get("teaching")?.aperture_max_m ?? APERTURE_M);
}

/** Goes to the step of a grasp: one that is there, or a new one. */
export function openGrasp(desk: Desk, existing: Grasp | null): void {
  withSubject(desk, (subject) => {
    const grasp = existing ?? begin(desk, subject, "side");
    const name = existing?.name ?? "";
    desk.store.learn({ step: "grasp", object: subject.object.name, name }, { pose: null, action: null, grasp });
  });
}

/** Puts the gripper back to where one may begin. */
export function beginGrasp(desk: Desk, from: "side" | "above"): void {
  withSubject(desk, (subject) => {
    const { object_from_tool, aperture_m } = begin(desk, subject, from);
    changeGrasp(desk, { object_from_tool, aperture_m });
  });
}

export function changeGrasp(desk: Desk, changed: Partial<Grasp>): void {
  const { grasp } = desk.store.get("draft");
  if (grasp !== null) {
    desk.store.drafted({ grasp: { ...grasp, ...changed } });
  }
}

export function canSaveGrasp(desk: Desk): boolean {
  return (desk.store.get("draft").grasp?.name ?? "") !== "";
}

export async function saveGrasp(desk: Desk, { of }: Subject): Promise<void> {
  const lesson = desk.store.get("lesson");
  const { grasp } = desk.store.get("draft");
  if (grasp === null) {
    return;
  }
  const outcome = await desk.edits.ask({ kind: "put_grasp", class: of.name, grasp });
  if (outcome.kind === "accepted" && isAt(desk, lesson)) {
    goTo(desk, "grasps");
  }
}

export function forgetGrasp(desk: Desk, { of }: Subject, name: string): void {
  void desk.edits.ask({ kind: "remove_grasp", class: of.name, name });
}
