// The plan: every step with its state in an icon and a word, and why one failed.

import { element, icon } from "../dom";
import type { Done, PlanStep } from "../protocol";
import type { Store } from "../store";
import {
  attemptsText,
  progressText,
  replansText,
  stepStateText,
  stepTitle,
  TEXT,
} from "../text";

export function planPanel(store: Store): HTMLElement {
  const progress = element("span", { class: "aside" });
  const outcome = element("div", { class: "outcome", role: "status" });
  const list = element("ol", { class: "steps" });
  const empty = element("p", { class: "empty" }, TEXT.planEmpty);
  const panel = element(
    "section",
    { class: "panel plan", "aria-labelledby": "plan-title" },
    element("header", {}, element("h2", { id: "plan-title" }, TEXT.plan), progress),
    outcome,
    element("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": TEXT.plan }, empty, list),
  );

  store.watch(["plan"], () => {
    const plan = store.get("plan");
    const steps = plan?.steps ?? [];
    empty.hidden = steps.length > 0;
    list.replaceChildren(...steps.map(stepItem));
    const n_done = steps.filter((step) => step.state === "done").length;
    const parts = steps.length === 0 ? [] : [progressText(n_done, steps.length)];
    if (plan !== null && plan.replans > 0) {
      parts.push(replansText(plan.replans));
    }
    progress.textContent = parts.join(" · ");
    list.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest" });
  });
  store.watch(["plan", "teaching"], () => {
    // Where a home is taught, no robot is at work.
    panel.hidden = store.get("teaching") !== null && store.get("plan") === null;
  });
  store.watch(["done"], () => {
    const done = store.get("done");
    outcome.hidden = done === null;
    outcome.replaceChildren(...(done === null ? [] : outcomeParts(done)));
    outcome.dataset["achieved"] = String(done?.achieved ?? false);
  });
  return panel;
}

function outcomeParts(done: Done): Node[] {
  return [
    icon(done.achieved ? "done" : "failed"),
    element(
      "div",
      {},
      element("strong", {}, done.achieved ? TEXT.achieved : TEXT.notAchieved),
      element("p", {}, done.summary),
    ),
  ];
}

function stepItem(step: PlanStep): HTMLElement {
  const drives = step.kind === "navigate";
  const state = [stepStateText(step.state)];
  if (step.attempts > 1) {
    state.push(attemptsText(step.attempts));
  }
  const item = element(
    "li",
    { "data-state": step.state, "data-kind": step.kind },
    element("span", { class: "badge" }, icon(step.state)),
    element(
      "div",
      { class: "step" },
      element(
        "span",
        { class: "title" },
        icon(step.kind),
        element("span", { class: "spoken" }, `${drives ? TEXT.driving : TEXT.acting}: `),
        stepTitle(step),
      ),
      element("span", { class: "state" }, state.join(" · ")),
    ),
  );
  if (step.state === "running") {
    item.setAttribute("aria-current", "step");
  }
  if (step.reason !== "") {
    item.append(element("p", { class: "reason" }, step.reason));
  }
  return item;
}
