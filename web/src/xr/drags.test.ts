import { describe, expect, it } from "vitest";

import { IDENTITY } from "../frames";
import type { ClientMessage, Edit, Pose, TaughtClass, Teaching } from "../protocol";
import { Store } from "../store";
import { Edits } from "../teach/edits";
import { firstAction, NO_DRAFT } from "../teach/lesson";
import type { Desk } from "../teach/desk";
import { alongRay, carriedDrag, jointDrag, thingDrag, worldDrag } from "./drags";
import { type MapFromXr, mapPoint } from "./map_from_xr";

const lever: TaughtClass = {
  name: "lever",
  description: "",
  provenance: "given",
  revision: 1,
  movable: false,
  form: null,
  parts: [],
  joints: [{ name: "handle", kind: "revolute", axis: [0, 0, 1], origin: [0, 0, 0], range: [0, 1.3] }],
  states: [],
  grasps: [],
  actions: [],
};
const teaching: Teaching = {
  closed: "",
  classes: [lever],
  objects: [{ name: "lever_1", class: "lever", pose: IDENTITY, provenance: "taught", revision: 1, colour_index: 0 }],
  catalogue: [],
  undo: null,
  redo: null,
  history: [],
  aperture_max_m: 0.1,
};
/** The person looks along the map's y. */
const here: MapFromXr = { position: [0, 0, 0], yaw: 0 };
const ray: Pose = { position: [0, 0, 1], orientation_xyzw: [0, 0, 0, 1] };
const at = (x: number, y: number, z: number): Pose => ({ ...ray, position: [x, y, z] });
/** The ray turned to the left about the upright of XR. */
const turned = (pose: Pose, angle: number): Pose => ({
  ...pose,
  orientation_xyzw: [0, Math.sin(angle / 2), 0, Math.cos(angle / 2)],
});

function desk(): { desk: Desk; edits: Edit[] } {
  const store = new Store();
  store.receive({ type: "teaching", ...teaching });
  store.handed({ snap: false });
  const edits: Edit[] = [];
  const send = (message: ClientMessage): boolean => {
    if (message.type === "edit") {
      edits.push(message.edit);
    }
    return true;
  };
  return { desk: { store, edits: new Edits(store, send), lookedAt: () => [0, 0] }, edits };
}

const close = (a: readonly number[] | undefined, b: readonly number[]): void =>
  b.forEach((value, index) => expect(a?.[index]).toBeCloseTo(value));

describe("a hand that has taken a thing", () => {
  it("carries it, and saves it once, when it lets go", () => {
    const { desk: own, edits } = desk();
    own.store.learn({ step: "place", object: "lever_1" });
    const drag = thingDrag(own, here, ray);
    drag?.move(at(0.2, 0.1, 0.5), null);
    // XR: right, up, back. Map: x, z, -y.
    close(own.store.get("draft").pose?.position, [0.2, 0.5, 0.1]);
    drag?.move(at(0.3, 0.1, 0.5), null);
    expect(edits).toEqual([]);
    drag?.end();
    expect(edits).toMatchObject([{ kind: "move_object", name: "lever_1" }]);
  });

  it("sweeps it about itself with its ray, but does not turn it unless asked to", () => {
    const { desk: own } = desk();
    own.store.learn({ step: "place", object: "lever_1" });
    const drag = thingDrag(own, here, ray);
    drag?.move(turned(ray, Math.PI / 2), null);
    // A metre ahead has become a metre to the left.
    close(own.store.get("draft").pose?.position, [-1, -1, 0]);
    close(own.store.get("draft").pose?.orientation_xyzw, [0, 0, 0, 1]);
    own.store.handed({ mode: "turn" });
    drag?.move(turned(ray, Math.PI / 2), null);
    close(own.store.get("draft").pose?.position, [0, 0, 0]);
    close(own.store.get("draft").pose?.orientation_xyzw, [0, 0, Math.SQRT1_2, Math.SQRT1_2]);
  });

  it("turns it with the other hand about the upright", () => {
    const { desk: own } = desk();
    own.store.learn({ step: "place", object: "lever_1" });
    const drag = thingDrag(own, here, ray);
    drag?.move(ray, [-0.5, 0, 1]);
    drag?.move(ray, [0, 0, 1.5]);
    // From its left to behind it: a quarter turn to the left, as seen from above.
    close(own.store.get("draft").pose?.orientation_xyzw, [0, 0, Math.SQRT1_2, Math.SQRT1_2]);
  });

  it("changes nothing once the step is another", () => {
    const { desk: own } = desk();
    own.store.learn({ step: "place", object: "lever_1" });
    const drag = thingDrag(own, here, ray);
    own.store.learn({ step: "grasps", object: "lever_1" });
    drag?.move(at(1, 1, 1), null);
    expect(own.store.get("draft")).toEqual(NO_DRAFT);
    expect(thingDrag(own, here, ray)).toBeNull();
  });
});

describe("a hand that has taken a part", () => {
  it("moves where the action ends, to the joint's stop and no farther", () => {
    const { desk: own } = desk();
    const action = firstAction("joint", lever, null, { radius: 0, height: 0 });
    own.store.learn({ step: "action", object: "lever_1", name: "" }, { ...NO_DRAFT, action });
    // Taken 10 cm to the right of its axis.
    const drag = jointDrag(own, here, at(0.1, 0, 1), [0.1, 0, 0], "initiation");
    drag?.move(at(0.1, 0, 0.9), null);
    expect(own.store.get("draft").action?.motion).toMatchObject({ initiation: expect.closeTo(Math.PI / 4) });
    drag?.move(at(-0.1, 0, 0.9), null);
    expect(own.store.get("draft").action?.motion).toMatchObject({ initiation: 1.3, termination: 1.3 });
  });

  it("is nothing where no part is taught", () => {
    const { desk: own } = desk();
    own.store.learn({ step: "place", object: "lever_1" });
    expect(jointDrag(own, here, ray, [0, 0, 0], "termination")).toBeNull();
  });
});

describe("a hand that has taken the world", () => {
  it("draws it along the floor and turns it, slowed down for fine work", () => {
    const shown: MapFromXr[] = [];
    const done: MapFromXr[] = [];
    const grabbed = alongRay(ray, 2);
    close(grabbed, [0, 0, -1]);
    let speed = 1;
    const drag = worldDrag(here, ray, grabbed, () => speed, (now) => shown.push(now), (now) => done.push(now));
    drag.move(at(0.5, 0.3, 1), null);
    const [first] = shown;
    // What was ahead is half a metre to the right now, on the floor still.
    close(first && mapPoint(first, [0.5, 0, -1]), [0, 1, 0]);
    speed = 0.5;
    drag.move(turned(ray, 0.4), null);
    expect(shown[1]?.yaw).toBeCloseTo(-0.2);
    expect(done).toEqual([]);
    drag.end();
    expect(done).toEqual([shown[1]]);
  });
});

describe("a hand that has taken a panel", () => {
  it("carries it as it holds it", () => {
    let panel = at(0, 0, -1);
    const drag = carriedDrag(ray, panel, (pose) => (panel = pose));
    drag.move(turned(ray, Math.PI / 2), null);
    close(panel.position, [-2, 0, 1]);
  });
});
