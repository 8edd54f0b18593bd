import { describe, expect, it } from "vitest";

import { composed } from "../frames";
import type { Pose, TaughtClass, TaughtObject, Teaching } from "../protocol";
import {
  effectAt,
  firstAction,
  firstGrasp,
  freeName,
  type Lesson,
  OVERVIEW,
  plainName,
  sizeOfForm,
  stepIndex,
  stillStands,
  subjectOf,
} from "./lesson";

const HERE: Pose = { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] };

const flask: TaughtClass = {
  name: "flask",
  description: "",
  provenance: "taught",
  revision: 3,
  movable: true,
  form: { kind: "cylinder", diameter_m: 0.06, height_m: 0.2 },
  parts: [],
  joints: [],
  states: [],
  grasps: [],
  actions: [],
};
const flask1: TaughtObject = {
  name: "flask_1",
  class: "flask",
  pose: HERE,
  provenance: "taught",
  revision: 4,
  colour_index: 0,
};
const teaching: Teaching = {
  closed: "",
  classes: [flask],
  objects: [flask1],
  catalogue: [],
  undo: null,
  redo: null,
  history: [],
  aperture_max_m: 0.12,
};

describe("a lesson", () => {
  it("is about an object and its class, as long as they are there", () => {
    const lesson: Lesson = { step: "grasp", object: "flask_1", name: "" };
    expect(subjectOf(lesson, teaching)).toEqual({ object: flask1, of: flask });
    expect(subjectOf(OVERVIEW, teaching)).toBeNull();
    expect(stillStands(lesson, teaching)).toBe(true);
    expect(stillStands({ ...lesson, name: "side" }, teaching)).toBe(false);
    expect(stillStands(lesson, { ...teaching, objects: [] })).toBe(false);
    expect(stillStands(OVERVIEW, { ...teaching, objects: [] })).toBe(true);
  });

  it("knows how far it is", () => {
    expect(stepIndex(OVERVIEW)).toBe(-1);
    expect(stepIndex({ step: "class" })).toBe(0);
    expect(stepIndex({ step: "grasp", object: "", name: "" })).toBe(2);
    expect(stepIndex({ step: "action", object: "", name: "" })).toBe(3);
  });
});

describe("names", () => {
  it("are such as plans and files can carry", () => {
    expect(plainName(" Green bottle! ")).toBe("green_bottle");
    expect(plainName("7 up")).toBe("up");
    expect(plainName("../../etc")).toBe("etc");
    expect(plainName("日本")).toBe("");
  });

  it("are free", () => {
    expect(freeName("side", [])).toBe("side");
    expect(freeName("side", ["side", "side_2"])).toBe("side_3");
  });
});

describe("where a person may begin", () => {
  it("a grasp comes level from the side, or straight from above, and opens wide enough", () => {
    const size = sizeOfForm({ kind: "cylinder", diameter_m: 0.06, height_m: 0.2 });
    const side = firstGrasp("side", flask, size, 0.12);
    expect(side.aperture_m).toBeCloseTo(0.09);
    expect(side.yaw_symmetric).toBe(true);
    const along = (pose: Pose, axis: [number, number, number]): number[] => {
      const tip = composed(pose, { position: axis, orientation_xyzw: [0, 0, 0, 1] });
      return tip.position.map((value, index) => Math.round(1e6 * (value - (pose.position[index] ?? 0))) / 1e6 + 0);
    };
    expect(along(side.object_from_tool, [0, 0, 1])).toEqual([1, 0, 0]);
    expect(along(side.object_from_tool, [1, 0, 0])).toEqual([0, 1, 0]);
    const above = firstGrasp("above", { ...flask, grasps: [side] }, size, 0.05);
    expect(along(above.object_from_tool, [0, 0, 1])).toEqual([0, 0, -1]);
    expect(above.aperture_m).toBe(0.05);
    expect(firstGrasp("side", { ...flask, grasps: [side] }, size, 0.12).name).toBe("side_2");
  });

  it("a thing is let go above what it goes into", () => {
    const bin: TaughtClass = { ...flask, name: "bin", movable: false };
    const action = firstAction("put_into", flask, bin, { radius: 0.15, height: 0.33 });
    expect(action.name).toBe("put_in_bin");
    expect(action.motion).toMatchObject({ kind: "put_into", class: "bin" });
    expect(action.motion.kind === "put_into" && action.motion.target_from_object.position).toEqual([0, 0, 0.41]);
  });

  it("a joint goes from one of its ends to the other", () => {
    const lever: TaughtClass = {
      ...flask,
      joints: [{ name: "handle", kind: "revolute", axis: [0, 0, 1], origin: [0, 0, 0], range: [0, 1.3] }],
    };
    const { motion } = firstAction("joint", lever, null, { radius: 0, height: 0 });
    expect(motion).toMatchObject({ kind: "joint", joint: "handle", initiation: 0, termination: 1.3, effect: "" });
  });

  it("what an action brings about is called as it is known", () => {
    const lever: TaughtClass = {
      ...flask,
      joints: [{ name: "handle", kind: "revolute", axis: [0, 0, 1], origin: [0, 0, 0], range: [0, 1.3] }],
      states: [{ name: "open", joint: "handle", range: [0.6, 1.35] }],
    };
    expect(effectAt(lever, "handle", 1, "")).toBe("open");
    expect(effectAt(lever, "handle", 1.5, "")).toBe("open");
    expect(effectAt(lever, "handle", 0.3, "open")).toBe("");
    expect(effectAt(lever, "handle", 0.3, "dripping")).toBe("dripping");
  });
});
