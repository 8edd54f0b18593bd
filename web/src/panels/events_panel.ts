// The event log, newest last, read out as it grows.

import { element, icon } from "../dom";
import type { Event as JobEvent } from "../protocol";
import type { Store } from "../store";
import { clockText, levelText, TEXT } from "../text";

export function eventsPanel(store: Store): HTMLElement {
  const empty = element("p", { class: "empty" }, TEXT.eventsEmpty);
  const list = element("ol", {
    class: "events",
    role: "log",
    "aria-live": "polite",
    "aria-labelledby": "events-title",
  });
  const scroll = element(
    "div",
    { class: "scroll", tabindex: "0", role: "group", "aria-label": TEXT.events },
    empty,
    list,
  );
  const panel = element(
    "section",
    { class: "panel log" },
    element("header", {}, element("h2", { id: "events-title" }, TEXT.events)),
    scroll,
  );

  let shown: readonly JobEvent[] = [];
  store.watch(["events"], () => {
    const events = store.get("events");
    // Only what is new is added, so that a screen reader does not begin again.
    const last = shown.at(-1);
    const known = last === undefined ? -1 : events.lastIndexOf(last);
    if (known < 0) {
      list.replaceChildren();
    }
    const atEnd = scroll.scrollHeight - scroll.scrollTop - scroll.clientHeight < 24;
    list.append(...events.slice(known + 1).map(eventItem));
    while (list.childElementCount > events.length) {
      list.firstElementChild?.remove();
    }
    shown = events;
    empty.hidden = events.length > 0;
    if (atEnd) {
      scroll.scrollTop = scroll.scrollHeight;
    }
  });
  store.watch(["events", "teaching"], () => {
    // Who teaches needs the room.
    panel.hidden = store.get("teaching") !== null && store.get("events").length === 0;
  });
  return panel;
}

function eventItem(event: JobEvent): HTMLElement {
  return element(
    "li",
    { "data-level": event.level },
    icon(event.level),
    element("span", { class: "spoken" }, `${levelText(event.level)}: `),
    element("time", {}, clockText(event.time_secs)),
    element("span", { class: "text" }, event.text),
  );
}
