// Teaching: one step at a time, with undo and redo of everything, and what was taught before.

import { element, icon, setAttributes } from "../dom";
import type { HistoryEntry } from "../protocol";
import { closedBecause, type Desk } from "../teach/desk";
import { type Lesson, stepIndex, STEPS, subjectOf } from "../teach/lesson";
import { TEACH } from "../text";
import { actionsStep, actionStep } from "./teach/action_steps";
import { classStep } from "./teach/class_step";
import { graspsStep, graspStep } from "./teach/grasp_steps";
import { overviewStep } from "./teach/overview_step";
import { placeStep } from "./teach/place_step";
import { button, type StepView } from "./teach/step";

export function teachPanel(desk: Desk): HTMLElement {
  const { store } = desk;
  const undo = button(TEACH.undo, () => void desk.edits.ask({ kind: "undo" }), { icon: "undo" });
  const redo = button(TEACH.redo, () => void desk.edits.ask({ kind: "redo" }), { icon: "redo" });
  const trail = element("ol", { class: "trail" });
  const title = element("h3", { tabindex: "-1", id: "teach-step" });
  const body = element("p", { class: "aside" });
  const refusal = element("p", { class: "refusal", role: "alert" });
  const closed = element("p", { class: "refusal", role: "status" });
  const saving = element("span", { class: "aside", role: "status" });
  const step = element("div", { class: "lesson", role: "group", "aria-labelledby": "teach-step" });
  const history = element("ol", { class: "history" });
  const panel = element(
    "section",
    { class: "panel teach", "aria-labelledby": "teach-title" },
    element(
      "header",
      {},
      element("h2", { id: "teach-title" }, TEACH.title),
      saving,
      element("div", { class: "row" }, undo, redo),
    ),
    trail,
    element(
      "div",
      { class: "scroll" },
      closed,
      title,
      body,
      refusal,
      step,
      element("details", { class: "past" }, element("summary", {}, TEACH.history), history),
    ),
  );

  let view: StepView | null = null;
  let shown: Lesson | null = null;
  const showLesson = (): void => {
    const lesson = store.get("lesson");
    if (lesson === shown) {
      return;
    }
    const isFirst = shown === null;
    shown = lesson;
    view = viewOf(desk, lesson);
    title.textContent = view?.title ?? "";
    body.textContent = view?.body ?? "";
    step.replaceChildren(...(view?.nodes ?? []));
    trail.replaceChildren(...trailOf(lesson));
    // Whoever listens, or works by keys, goes on from the new step's title.
    if (!isFirst && !panel.hidden) {
      title.focus({ preventScroll: true });
    }
  };
  // A refused edit leaves what was written: what is so is shown again.
  store.watch(["lesson", "draft", "teaching", "unanswered"], () => {
    const teaching = store.get("teaching");
    panel.hidden = teaching === null;
    if (teaching === null) {
      return;
    }
    showLesson();
    view?.show();
  });
  store.watch(["teaching", "unanswered", "connection", "role"], () => {
    const teaching = store.get("teaching");
    const why = closedBecause(store);
    const works = teaching !== null && why === "" && store.get("connection").kind === "open";
    closed.hidden = teaching === null || why === "";
    closed.textContent = why;
    setAttributes(step, { inert: teaching !== null && why !== "" });
    const busy = store.get("unanswered") > 0;
    saving.textContent = busy ? TEACH.saving : "";
    label(undo, works && !busy, teaching?.undo ?? null, TEACH.undo, TEACH.nothingToUndo);
    label(redo, works && !busy, teaching?.redo ?? null, TEACH.redo, TEACH.nothingToRedo);
    history.replaceChildren(...(teaching?.history ?? []).map(historyItem));
  });
  store.watch(["refusal"], () => {
    const why = store.get("refusal");
    refusal.hidden = why === "";
    refusal.replaceChildren(...(why === "" ? [] : [icon("warning"), `${TEACH.refused}: ${why}`]));
  });
  return panel;
}

function viewOf(desk: Desk, lesson: Lesson): StepView | null {
  if (lesson.step === "overview") {
    return overviewStep(desk);
  }
  if (lesson.step === "class") {
    return classStep(desk);
  }
  const subject = subjectOf(lesson, desk.store.get("teaching"));
  if (subject === null) {
    return null;
  }
  switch (lesson.step) {
    case "place":
      return placeStep(desk, lesson.object);
    case "grasps":
      return graspsStep(desk, subject);
    case "grasp":
      return graspStep(desk, subject, lesson.name);
    case "actions":
      return actionsStep(desk, subject);
    case "action":
      return actionStep(desk, subject, lesson.name);
  }
}

/** Where in the course of teaching a lesson is. */
function trailOf(lesson: Lesson): HTMLElement[] {
  const at = stepIndex(lesson);
  return STEPS.map((step, index) => {
    const item = element("li", { "data-state": index < at ? "done" : index === at ? "running" : "pending" });
    item.append(`${index + 1} ${TEACH.steps[step]}`);
    if (index === at) {
      item.setAttribute("aria-current", "step");
    }
    return item;
  });
}

function label(node: HTMLButtonElement, works: boolean, what: string | null, does: string, nothing: string): void {
  node.disabled = !works || what === null;
  node.title = what === null ? nothing : `${does}: ${what}`;
}

function historyItem({ entry, what, author }: HistoryEntry): HTMLElement {
  return element("li", {}, element("span", { class: "aside" }, String(entry)), ` ${what} `, element("span", { class: "aside" }, author));
}
