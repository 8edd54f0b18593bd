// The desk at which a person teaches: what the steps work with, and the way from one to the next. The same for the page
// and for a headset.

import type { Store } from "../store";
import { TEACH } from "../text";
import type { Edits } from "./edits";
import { type Lesson, subjectOf, type Subject } from "./lesson";

export interface Desk {
  readonly store: Store;
  readonly edits: Edits;
  /** Where on the floor, in the world, a person looks. */
  lookedAt(): [number, number];
}

/** Runs something with the object that is being taught and its class. */
export function withSubject(desk: Desk, run: (subject: Subject) => void): void {
  const subject = subjectOf(desk.store.get("lesson"), desk.store.get("teaching"));
  if (subject !== null) {
    run(subject);
  }
}

/** Goes to a step of the same object. */
export function goTo(desk: Desk, step: "place" | "grasps" | "actions"): void {
  const lesson = desk.store.get("lesson");
  if ("object" in lesson) {
    desk.store.learn({ step, object: lesson.object });
  }
}

/** Whether a person is still at this lesson, as after an answer that took its time. */
export function isAt(desk: Desk, lesson: Lesson): boolean {
  return desk.store.get("lesson") === lesson;
}

/** Why this page can change nothing; empty when it can. */
export function closedBecause(store: Store): string {
  return store.may("teach") ? (store.get("teaching")?.closed ?? "") : TEACH.mayNot;
}
