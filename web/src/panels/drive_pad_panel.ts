// The pad to drive by hand: there only while the job takes driving. Buttons and keys hold alike.

import type { StudioConnection } from "../connection";
import { element, icon, isTyping } from "../dom";
import { Hand, type Push, PUSHES } from "../drive_pad";
import type { Store } from "../store";
import { pushText, TEXT } from "../text";

export function drivePadPanel(store: Store, connection: StudioConnection): HTMLElement {
  const hand = new Hand(
    (velocity) => connection.send({ type: "drive", ...velocity }),
    (callback, millis) => {
      const timer = setInterval(callback, millis);
      return () => clearInterval(timer);
    },
  );
  const buttons = PUSHES.map((push) => ({ push, node: pushButton(push) }));
  const show = (): void => {
    for (const { push, node } of buttons) {
      node.classList.toggle("held", hand.pushes.has(push));
    }
  };
  const hold = (source: string, push: Push): void => {
    if (store.takesDriving()) {
      hand.hold(source, push);
      show();
    }
  };
  const release = (source: string): void => {
    hand.release(source);
    show();
  };
  const releaseAll = (): void => {
    hand.releaseAll();
    show();
  };

  for (const { push, node } of buttons) {
    listenToButton(node, push, hold, release);
  }
  listenToKeys(hold, release, releaseAll);
  window.addEventListener("blur", releaseAll);
  document.addEventListener("visibilitychange", releaseAll);

  const done = element("button", { type: "button", class: "primary" }, icon("done"), TEXT.driveDone);
  done.addEventListener("click", () => connection.send({ type: "drive_done" }));
  const panel = element(
    "section",
    { class: "drive-pad group", role: "group", "aria-label": TEXT.drive },
    element("div", { class: "pushes" }, ...buttons.map(({ node }) => node)),
    element("p", { class: "aside" }, TEXT.driveHint),
    done,
  );
  store.watch(["status", "connection", "done", "waiting"], () => {
    const takesDriving = store.takesDriving();
    if (!takesDriving) {
      releaseAll();
    }
    panel.hidden = store.get("status")?.takes_driving !== true;
    for (const { node } of buttons) {
      node.disabled = !takesDriving;
    }
    done.disabled = !takesDriving || store.get("waiting") !== null;
  });
  return panel;
}

function pushButton(push: Push): HTMLButtonElement {
  const text = pushText(push.name);
  const cap = push.keys[0]?.toUpperCase() ?? "";
  return element(
    "button",
    {
      type: "button",
      "aria-label": text,
      "aria-keyshortcuts": push.keys.join(" "),
      title: `${text} (${cap})`,
    },
    icon(push.name),
    element("kbd", { "aria-hidden": "true" }, cap),
  );
}

type Hold = (source: string, push: Push) => void;
type Release = (source: string) => void;

/** A finger, a mouse, or space and enter on the focused button. */
function listenToButton(node: HTMLButtonElement, push: Push, hold: Hold, release: Release): void {
  node.addEventListener("pointerdown", (event) => {
    if (event.button === 0) {
      node.setPointerCapture(event.pointerId);
      hold(`pointer ${event.pointerId}`, push);
    }
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
    node.addEventListener(end, (event) => release(`pointer ${event.pointerId}`));
  }
  // A long press is no question for a menu.
  node.addEventListener("contextmenu", (event) => event.preventDefault());
  const own = `button ${push.name}`;
  const isPress = (event: KeyboardEvent): boolean => event.key === " " || event.key === "Enter";
  node.addEventListener("keydown", (event) => {
    if (isPress(event)) {
      event.preventDefault();
      hold(own, push);
    }
  });
  node.addEventListener("keyup", (event) => {
    if (isPress(event)) {
      event.preventDefault();
      release(own);
    }
  });
  node.addEventListener("blur", () => release(own));
}

/** Keys anywhere on the page, but for those that a focused part of it has taken for itself, such as the picture arrows. */
function listenToKeys(hold: Hold, release: Release, releaseAll: () => void): void {
  document.addEventListener("keydown", (event) => {
    if (document.querySelector("dialog[open]") !== null) {
      releaseAll();
      return;
    }
    if (event.defaultPrevented || isTyping(event) || event.repeat || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const key = event.key.toLowerCase();
    const push = PUSHES.find((one) => one.keys.includes(key));
    if (push !== undefined) {
      event.preventDefault();
      hold(`key ${key}`, push);
    }
  });
  document.addEventListener("keyup", (event) => release(`key ${event.key.toLowerCase()}`));
}
