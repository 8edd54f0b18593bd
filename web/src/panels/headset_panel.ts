// The way into a headset, or why there is none.

import { element } from "../dom";
import type { Store } from "../store";
import { alignmentText, HEADSET, headsetText } from "../text";

export interface HeadsetDoor {
  readonly node: HTMLElement;
  /** There is a picture to enter. */
  open(enter: () => void): void;
}

export function headsetPanel(store: Store): HeadsetDoor {
  let enter: (() => void) | null = null;
  const button = element("button", { type: "button", class: "primary" });
  button.addEventListener("click", () => enter?.());
  const how = element("p", { class: "aside", role: "status" });
  const alignment = element("p", { class: "aside alignment", role: "status" });
  const node = element(
    "section",
    { class: "panel headset", "aria-labelledby": "headset-title" },
    element("header", {}, element("h2", { id: "headset-title" }, HEADSET.title)),
    how,
    alignment,
    button,
  );
  const show = (): void => {
    const headset = store.get("headset");
    const { offer, worn } = headset;
    how.textContent = headsetText(headset);
    button.hidden = offer.kind !== "offered" || worn !== null;
    button.disabled = enter === null;
    button.textContent = offer.kind === "offered" ? HEADSET.enter[offer.mode] : "";
    const { epoch } = store.get("alignment");
    alignment.hidden = epoch === 0;
    alignment.textContent = alignmentText(store.get("alignment"));
  };
  store.watch(["headset", "alignment"], show);
  return {
    node,
    open(run) {
      enter = run;
      show();
    },
  };
}
