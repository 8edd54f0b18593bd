// What the steps of teaching look like on the page.

import { element, icon, type IconName } from "../../dom";

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
