// The bar at the top: goal, what the robot is at, its clock, and how the connection stands.

import { element } from "../dom";
import type { Store } from "../store";
import { activityText, clockText, connectionText, speedText, TEXT } from "../text";

/** Numbers that change faster than this cannot be read. */
const READOUT_MILLIS = 250;

export function statusBar(store: Store, bar: HTMLElement): void {
  const goal = element("strong", { class: "goal" });
  const activity = element("span", { class: "chip" });
  const time = element("output", { "aria-live": "off" });
  const speed = element("output", { "aria-live": "off" });
  const connection = element("span", { class: "connection", role: "status" });
  bar.append(
    element("h1", { class: "brand" }, TEXT.name),
    element("p", { class: "job", role: "status" }, activity, goal),
    element(
      "dl",
      { class: "readout" },
      element("div", {}, element("dt", {}, TEXT.time), element("dd", {}, time)),
      element("div", {}, element("dt", {}, TEXT.speed), element("dd", {}, speed)),
    ),
    connection,
  );

  store.watch(["status"], () => {
    const status = store.get("status");
    goal.textContent = status?.goal ?? TEXT.noGoal;
    const label = status === null ? "" : activityText(status.activity);
    activity.textContent = status?.paused === true ? TEXT.paused : label;
    activity.dataset["activity"] = status?.paused === true ? "paused" : (status?.activity ?? "");
    activity.hidden = status === null;
  });
  store.watch(["connection", "done", "role", "owner", "client"], () => {
    const now = store.get("connection");
    const owner = store.get("owner");
    const who = { role: store.get("role"), isOwned: owner !== null && owner !== store.get("client") };
    connection.textContent = connectionText(now, store.get("done") !== null, who);
    connection.dataset["kind"] = now.kind;
  });
  const readOut = (): void => {
    const live = store.get("live");
    setText(time, live === null ? "–" : clockText(live.time_secs));
    setText(speed, live === null ? "–" : speedText(live.sim_speed));
  };
  readOut();
  setInterval(readOut, READOUT_MILLIS);
}

function setText(target: HTMLElement, text: string): void {
  if (target.textContent !== text) {
    target.textContent = text;
  }
}
