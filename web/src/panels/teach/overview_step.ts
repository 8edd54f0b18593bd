// The things of the home, each to be changed, and the way to a new one.

import { element } from "../../dom";
import { regionColour } from "../../palette";
import type { TaughtObject } from "../../protocol";
import type { Desk } from "../../teach/desk";
import { TEACH, words } from "../../text";
import { button, row, type StepView } from "./step";

export function overviewStep(desk: Desk): StepView {
  const empty = element("p", { class: "empty" }, TEACH.overviewEmpty);
  const list = element("ul", { class: "things" });
  const add = button(TEACH.teachNew, () => desk.store.learn({ step: "class" }), { primary: true, icon: "add" });
  return {
    title: TEACH.overviewTitle,
    body: TEACH.overview,
    nodes: [empty, list, row(add)],
    show() {
      const objects = desk.store.get("teaching")?.objects ?? [];
      empty.hidden = objects.length > 0;
      list.replaceChildren(...objects.map((object) => item(desk, object)));
    },
  };
}

function item(desk: Desk, object: TaughtObject): HTMLElement {
  const chip = element("span", { class: "swatch", "aria-hidden": "true" });
  chip.style.backgroundColor = regionColour(object.colour_index);
  const name = words(object.name);
  const change = button(
    TEACH.change,
    () => desk.store.learn({ step: "place", object: object.name }),
    { name: `${TEACH.change} ${name}` },
  );
  return element("li", {}, chip, element("b", {}, name), element("span", { class: "aside" }, words(object.class)), change);
}
