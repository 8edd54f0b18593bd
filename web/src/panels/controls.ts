// Pause, stop, and what to show: the same as buttons and as keys.

import type { StudioConnection } from "../connection";
import { element, icon, type IconName, isTyping, setAttributes } from "../dom";
import type { Store, Wishes } from "../store";
import { TEXT } from "../text";

interface Action {
  readonly key: string;
  /** The key as its cap shows it. */
  readonly cap: string;
  readonly run: () => void;
}

export function controls(store: Store, connection: StudioConnection): HTMLElement {
  const dialog = stopDialog(() => connection.send({ type: "stop" }));
  const pauseOrResume = (): void => {
    if (store.takesCommands() && store.may("execute") && store.get("waiting") === null) {
      const paused = store.get("status")?.paused === true;
      connection.send({ type: paused ? "resume" : "pause" });
    }
  };
  const askToStop = (): void => {
    if (store.takesCommands() && !dialog.open) {
      dialog.showModal();
    }
  };

  const pause = button({ key: " ", cap: "Space", run: pauseOrResume }, "pause", TEXT.pause);
  const stop = button({ key: "s", cap: "S", run: askToStop }, "stop", TEXT.stop);
  pause.node.classList.add("primary");
  stop.node.classList.add("danger");
  store.watch(["status", "connection", "done", "waiting"], () => {
    const paused = store.get("status")?.paused === true;
    pause.show(paused ? "running" : "pause", paused ? TEXT.resume : TEXT.pause);
    // What cannot be done is not shown; a stop is for everybody.
    pause.node.hidden = !store.may("execute");
    pause.node.disabled = !store.takesCommands() || store.get("waiting") !== null;
    stop.node.disabled = !store.takesCommands();
  });

  const toggle = (wish: keyof Wishes, key: string, name: IconName, label: string): Button => {
    const made = button({ key, cap: key.toUpperCase(), run: () => store.toggle(wish) }, name, label);
    store.watch(["wishes"], () => {
      setAttributes(made.node, { "aria-pressed": String(store.get("wishes")[wish]) });
    });
    return made;
  };
  const toggles = [
    toggle("follow", "f", "follow", TEXT.follow),
    toggle("map", "m", "map", TEXT.map),
    toggle("regions", "r", "regions", TEXT.regions),
    toggle("labels", "l", "labels", TEXT.labels),
  ];

  listen([pause, stop, ...toggles], dialog);
  const jobTools = element(
    "div",
    { class: "group", role: "group", "aria-label": TEXT.jobTools },
    pause.node,
    stop.node,
  );
  store.watch(["teaching"], () => {
    // Where a home is taught, no robot is at work.
    jobTools.hidden = store.get("teaching") !== null;
  });
  return element(
    "div",
    { class: "controls" },
    jobTools,
    element(
      "div",
      { class: "group view-tools", role: "group", "aria-label": TEXT.viewTools },
      ...toggles.map((made) => made.node),
    ),
    dialog,
  );
}

interface Button {
  readonly node: HTMLButtonElement;
  readonly action: Action;
  readonly show: (name: IconName, label: string) => void;
}

function button(action: Action, name: IconName, label: string): Button {
  const node = element("button", {
    type: "button",
    "aria-keyshortcuts": action.cap,
  });
  const show = (shown: IconName, text: string): void => {
    node.replaceChildren(
      icon(shown),
      element("span", { class: "caption" }, text),
      element("kbd", { "aria-hidden": "true" }, action.cap),
    );
    node.title = `${text} (${action.cap})`;
  };
  show(name, label);
  node.addEventListener("click", action.run);
  return { node, action, show };
}

/** One key, one action; not while the dialog asks, and not with a modifier, which is the browser's. */
function listen(buttons: readonly Button[], dialog: HTMLDialogElement): void {
  document.addEventListener("keydown", (event) => {
    if (dialog.open || isTyping(event) || event.repeat || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    // A focused button takes the space bar for itself.
    if (event.key === " " && event.target instanceof HTMLButtonElement) {
      return;
    }
    const hit = buttons.find((made) => made.action.key === event.key.toLowerCase());
    if (hit !== undefined) {
      event.preventDefault();
      hit.action.run();
    }
  });
}

function stopDialog(stop: () => void): HTMLDialogElement {
  const yes = element("button", { type: "button", class: "danger" }, TEXT.stopYes);
  const no = element("button", { type: "button" }, TEXT.stopNo);
  const dialog = element(
    "dialog",
    { "aria-labelledby": "stop-title", "aria-describedby": "stop-body" },
    element("h2", { id: "stop-title" }, TEXT.stopTitle),
    element("p", { id: "stop-body" }, TEXT.stopBody),
    element("div", { class: "group" }, yes, no),
  );
  yes.addEventListener("click", () => {
    dialog.close();
    stop();
  });
  no.addEventListener("click", () => dialog.close());
  return dialog;
}
