// What the steps of teaching have in common.

import { element, icon, type IconName } from "../../dom";
import type { Store } from "../../store";
import type { Edits } from "../../teach/edits";
import { type Lesson, subjectOf, type Subject } from "../../teach/lesson";

/** What a step works with. */
export interface Desk {
  readonly store: Store;
  readonly edits: Edits;
  /** Where on the floor, in the world, a person looks. */
  lookedAt(): [number, number];
}

/** A step on the page. */
export interface StepView {
  readonly title: string;
  /** What is being told of the thing, and what comes next. */
  readonly body: string;
  readonly nodes: readonly Node[];
  /** Follows store and draft. */
  show(): void;
}

export function button(text: string, run: () => void, look: { primary?: boolean; icon?: IconName; name?: string } = {}): HTMLButtonElement {
  const node = element("button", { type: "button" }, ...(look.icon === undefined ? [] : [icon(look.icon)]), text);
  node.classList.toggle("primary", look.primary === true);
  if (look.name !== undefined) {
    node.setAttribute("aria-label", look.name);
  }
  node.addEventListener("click", run);
  return node;
}

/** Buttons side by side. */
export function row(...buttons: readonly Node[]): HTMLElement {
  return element("div", { class: "row" }, ...buttons);
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
