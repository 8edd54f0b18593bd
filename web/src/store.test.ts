import { beforeEach, describe, expect, it } from "vitest";

import type { Body, Plan, ServerMessage, State, Status, Training } from "./protocol";
import { VERSION } from "./protocol";
import { EVENTS_MAX, Store } from "./store";

const hello: ServerMessage = { type: "hello", version: VERSION, session: "a", client: "a-1", role: "execute" };
const plan: Plan = { replans: 0, steps: [] };
const status: Status = { goal: "light off", activity: "acting", paused: false, takes_driving: false };
const state: State = {
  time_secs: 1,
  sim_speed: 2,
  base: { x: 0, y: 0, yaw: 0 },
  body_poses: [],
  joints: [],
};

const training: Training = {
  name: "door-cip-0",
  task: "door",
  ablation: "cip",
  seed: "0",
  running: true,
  episodes: 0,
  env_steps: 0,
  violations: 0,
  recent_success_rate: null,
  evaluations: [],
};

function event(text: string): ServerMessage {
  return { type: "event", level: "info", text, time_secs: 0 };
}

describe("the store", () => {
  let store: Store;

  beforeEach(() => {
    store = new Store();
    store.receive(hello);
  });

  it("keeps a scene of each source and the latest of everything else", () => {
    store.receive({ type: "scene", source: "home", bodies: [] });
    store.receive({ type: "scene", source: "robot", bodies: [] });
    store.receive({ type: "scene", source: "home", bodies: [body("bin")] });
    store.receive({ type: "state", ...state });
    store.receive({ type: "state", ...state, time_secs: 2 });
    expect([...store.get("scenes").keys()].sort()).toEqual(["home", "robot"]);
    expect(store.get("scenes").get("home")?.bodies.map(({ name }) => name)).toEqual(["bin"]);
    expect(store.get("live")?.time_secs).toBe(2);
  });

  it("forgets the old picture when it is greeted, but not what a person wished to see", () => {
    store.receive({ type: "plan", ...plan });
    store.receive(event("old"));
    store.receive({ type: "done", achieved: true, summary: "" });
    store.receive({ type: "trainings", trainings: [training] });
    expect(store.get("trainings")).toEqual([training]);
    store.toggle("map");
    store.receive({ ...hello, session: "b" });
    expect(store.get("plan")).toBeNull();
    expect(store.get("events")).toEqual([]);
    expect(store.get("done")).toBeNull();
    expect(store.get("trainings")).toEqual([]);
    expect(store.get("session")).toBe("b");
    expect(store.get("wishes").map).toBe(false);
  });

  it("keeps the last picture while the connection is lost", () => {
    store.receive({ type: "plan", ...plan });
    store.connection({ kind: "lost", retryInSecs: 1 });
    expect(store.get("plan")).not.toBeNull();
    expect(store.get("connection").kind).toBe("lost");
  });

  it("says when page and studio are of different versions", () => {
    store.receive({ ...hello, version: VERSION + 1 });
    expect(store.get("connection")).toEqual({ kind: "mismatch", theirs: VERSION + 1 });
  });

  it("keeps events in order and no more than it can show", () => {
    for (let index = 0; index < EVENTS_MAX + 10; index++) {
      store.receive(event(String(index)));
    }
    const events = store.get("events");
    expect(events).toHaveLength(EVENTS_MAX);
    expect(events.at(0)?.text).toBe("10");
    expect(events.at(-1)?.text).toBe(String(EVENTS_MAX + 9));
  });

  it("tells who watches a slice, and nobody else", () => {
    const told: string[] = [];
    store.watch(["plan"], () => told.push("plan"));
    store.watch(["status", "done"], () => told.push("status or done"));
    expect(told).toEqual(["plan", "status or done"]);
    told.length = 0;
    store.receive({ type: "plan", ...plan });
    store.receive({ type: "state", ...state });
    store.receive({ type: "done", achieved: false, summary: "" });
    expect(told).toEqual(["plan", "status or done"]);
  });

  it("takes commands only while a job runs and is connected", () => {
    expect(store.takesCommands()).toBe(false);
    store.receive({ type: "status", ...status });
    expect(store.takesCommands()).toBe(true);
    store.connection({ kind: "lost", retryInSecs: 1 });
    expect(store.takesCommands()).toBe(false);
    store.receive(hello);
    store.receive({ type: "status", ...status, activity: "finished" });
    expect(store.takesCommands()).toBe(false);
    store.receive({ type: "status", ...status });
    store.receive({ type: "done", achieved: true, summary: "" });
    expect(store.takesCommands()).toBe(false);
  });

  it("takes driving only from a hand that the job waits for", () => {
    store.receive({ type: "status", ...status });
    expect(store.takesDriving()).toBe(false);
    store.receive({ type: "status", ...status, takes_driving: true });
    expect(store.takesDriving()).toBe(true);
    store.receive({ type: "status", ...status, takes_driving: true, paused: true });
    expect(store.takesDriving()).toBe(false);
    store.receive({ type: "status", ...status, takes_driving: true });
    store.connection({ kind: "lost", retryInSecs: 1 });
    expect(store.takesDriving()).toBe(false);
  });

  it("may do what its role says and all below it", () => {
    expect(store.may("execute")).toBe(true);
    store.receive({ ...hello, role: "teach" });
    expect([store.may("view"), store.may("teach"), store.may("execute")]).toEqual([true, true, false]);
    store.receive({ type: "status", ...status, takes_driving: true });
    // It can still stop the robot.
    expect([store.takesDriving(), store.takesCommands()]).toEqual([false, true]);
  });

  it("waits for a command to show, and no longer", () => {
    store.sent("pause");
    expect(store.get("waiting")).toBe("pause");
    store.receive({ type: "status", ...status, paused: true });
    expect(store.get("waiting")).toBeNull();
    store.sent("resume");
    store.connection({ kind: "lost", retryInSecs: 1 });
    expect(store.get("waiting")).toBeNull();
  });
});

function body(name: string): Body {
  const pose: Body["pose"] = { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] };
  return { name, pose, shapes: [] };
}
