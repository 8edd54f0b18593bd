import { Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";

import { composed, IDENTITY, inverted, orientationFromRpy } from "../frames";
import type { ClassJoint, Pose, TaughtClass, TaughtObject, Teaching } from "../protocol";
import { Store } from "../store";
import { dragTo, heldOf, jointDragged, jointTravel, uprightTurn, worldFromHeld } from "./drag";
import { firstAction, firstGrasp, NO_DRAFT } from "./lesson";

const flask: TaughtClass = {
  name: "flask",
  description: "",
  provenance: "taught",
  revision: 1,
  movable: true,
  form: { kind: "cylinder", diameter_m: 0.06, height_m: 0.2 },
  parts: [],
  joints: [],
  states: [],
  grasps: [],
  actions: [],
};
const bin: TaughtClass = { ...flask, name: "bin", movable: false };
const at = (x: number, y: number, yaw: number): Pose => ({
  position: [x, y, 0],
  orientation_xyzw: orientationFromRpy([0, 0, yaw]),
});
const object = (name: string, of: TaughtClass, pose: Pose): TaughtObject => ({
  name,
  class: of.name,
  pose,
  provenance: "taught",
  revision: 1,
  colour_index: 0,
});
const teaching: Teaching = {
  closed: "",
  classes: [bin, flask],
  objects: [object("bin_1", bin, at(2, 0, 0)), object("flask_1", flask, at(1, 1, Math.PI / 2))],
  catalogue: [],
  undo: null,
  redo: null,
  history: [],
  aperture_max_m: 0.1,
};

function storeWith(snap: boolean): Store {
  const store = new Store();
  store.receive({ type: "teaching", ...teaching });
  store.handed({ snap, speed: 1 });
  return store;
}

const close = (a: readonly number[], b: readonly number[]): void =>
  a.forEach((value, index) => expect(value).toBeCloseTo(b[index] ?? Number.NaN, 9));

describe("what is held", () => {
  it("is the thing itself in the world, on the home's grid", () => {
    const store = storeWith(true);
    store.learn({ step: "place", object: "flask_1" });
    const start = at(1, 1, Math.PI / 2);
    const now = dragTo(store, start, { ...start, position: [1.332, 1, 0.02] });
    close(now?.position ?? [], [1.35, 1, 0]);
    expect(store.get("draft").pose).toEqual(now);
  });

  it("is a gripper in the frame of the thing", () => {
    const store = storeWith(false);
    const grasp = firstGrasp("side", flask, { radius: 0.03, height: 0.2 }, 0.1);
    store.learn({ step: "grasp", object: "flask_1", name: "" }, { ...NO_DRAFT, grasp });
    const held = heldOf(store.get("lesson"), store.get("draft"), teaching);
    const start = held === null ? IDENTITY : worldFromHeld(held);
    const [x, y, z] = start.position;
    // A centimetre along the world's y is one along the thing's x, which is turned by a quarter.
    dragTo(store, start, { ...start, position: [x, y + 0.01, z] });
    close(store.get("draft").grasp?.object_from_tool.position ?? [], [0.01, 0, 0.09]);
  });

  it("is a copy in the frame of what it is put into, if there is one", () => {
    const store = storeWith(false);
    const action = firstAction("put_into", flask, bin, { radius: 0.15, height: 0.33 });
    store.learn({ step: "action", object: "flask_1", name: "" }, { ...NO_DRAFT, action });
    const start: Pose = { ...IDENTITY, position: [2, 0, 0.41] };
    dragTo(store, start, { ...start, position: [2.1, 0, 0.5] });
    expect(store.get("draft").action?.motion).toMatchObject({
      target_from_object: { position: [expect.closeTo(0.1), 0, 0.5] },
    });
    expect(heldOf(store.get("lesson"), store.get("draft"), { ...teaching, objects: teaching.objects.slice(1) })).toBeNull();
  });

  it("is nothing where nothing is dragged as a whole", () => {
    const store = storeWith(false);
    expect(dragTo(store, IDENTITY, at(1, 0, 0))).toBeNull();
    store.learn({ step: "grasps", object: "flask_1" });
    expect(dragTo(store, IDENTITY, at(1, 0, 0))).toBeNull();
    expect(store.get("draft")).toEqual(NO_DRAFT);
  });
});

describe("a joint", () => {
  const lever: ClassJoint = { name: "lever", kind: "revolute", axis: [0, 0, 1], origin: [1, 0, 0], range: [-0.4, 1.3] };
  const slide: ClassJoint = { name: "slide", kind: "prismatic", axis: [0, 2, 0], origin: [0, 0, 0], range: [0, 0.4] };

  it("turns with the point of its part about its axis", () => {
    expect(jointTravel(lever, [2, 0, 0.3], [1, 1, 0.1])).toBeCloseTo(Math.PI / 2);
    expect(jointTravel(lever, [2, 0, 0], [1, -1, 0])).toBeCloseTo(-Math.PI / 2);
    expect(jointTravel(lever, [1, 0, 0.2], [1, 1, 0])).toBe(0);
  });

  it("slides along its axis, of whatever length that is written", () => {
    expect(jointTravel(slide, [0.1, 0.1, 0], [0.5, 0.3, 0.4])).toBeCloseTo(0.2);
  });

  it("stops at its ends, and between them goes by whole steps", () => {
    const drawn = { snap: true, speed: 1 };
    expect(jointDragged(lever, 0, 2, drawn)).toBe(1.3);
    expect(jointDragged(lever, 0, -2, drawn)).toBe(-0.4);
    expect(jointDragged(lever, 0, 0.5, drawn)).toBeCloseTo(Math.PI / 6);
    expect(jointDragged(slide, 0.1, 0.0623, { snap: false, speed: 0.5 })).toBeCloseTo(0.13115);
  });
});

describe("a turn", () => {
  it("keeps what is about the upright", () => {
    const yaw = new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), 0.7);
    const tilt = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), 0.3);
    expect(uprightTurn(yaw.clone().multiply(tilt)).angleTo(yaw)).toBeCloseTo(0);
    expect(uprightTurn(tilt).angleTo(new Quaternion())).toBeCloseTo(0);
    // Upside down there is no heading to speak of.
    expect(uprightTurn(new Quaternion(1, 0, 0, 0))).toEqual(new Quaternion());
  });

  it("and back again is none", () => {
    const pose: Pose = { position: [1, 2, 3], orientation_xyzw: orientationFromRpy([0.1, 0.2, 0.3]) };
    const whole = composed(inverted(pose), pose);
    close(whole.position, [0, 0, 0]);
    close(whole.orientation_xyzw, [0, 0, 0, 1]);
  });
});
