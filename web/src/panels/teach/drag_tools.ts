// How dragging works: what it changes, whether it snaps, how fast it is. The same for everything that is dragged.

import { element, setAttributes } from "../../dom";
import type { Store } from "../../store";
import { TEACH } from "../../text";
import { button } from "./step";

export function dragTools(store: Store): HTMLElement {
  const move = button(TEACH.move, () => store.handed({ mode: "move" }));
  const turn = button(TEACH.turn, () => store.handed({ mode: "turn" }));
  const snap = button(TEACH.snap, () => store.handed({ snap: !store.get("hand").snap }));
  const speed = element("input", { type: "range", min: "0.1", max: "1", step: "0.1", "aria-label": TEACH.speed });
  speed.addEventListener("input", () => store.handed({ speed: speed.valueAsNumber }));
  const hand = store.get("hand");
  speed.value = String(hand.speed);
  const press = (): void => {
    const now = store.get("hand");
    setAttributes(move, { "aria-pressed": String(now.mode === "move") });
    setAttributes(turn, { "aria-pressed": String(now.mode === "turn") });
    setAttributes(snap, { "aria-pressed": String(now.snap) });
  };
  for (const node of [move, turn, snap]) {
    node.addEventListener("click", press);
  }
  press();
  return element(
    "div",
    { class: "row drag-tools", role: "group", "aria-label": TEACH.drag },
    move,
    turn,
    snap,
    element("label", { class: "slider" }, element("span", {}, TEACH.speed), speed),
  );
}
