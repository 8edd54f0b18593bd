import { describe, expect, it } from "vitest";

import { orientationFromRpy, rpyOf } from "../frames";
import type { Pose } from "../protocol";
import { GRID, settled } from "./settle";

const start: Pose = { position: [0.123, 0.5, 0], orientation_xyzw: orientationFromRpy([0, 0, 0.3]) };
const free = { snap: false, speed: 1 };
const drawn = { snap: true, speed: 1 };

function moved(x: number, y: number, z: number): Pose {
  return { ...start, position: [x, y, z] };
}

describe("a drag", () => {
  it("goes where the hand goes, or a share of the way for fine work", () => {
    expect(settled(start, moved(1.123, 0.5, 0.2), free, GRID.home).position).toEqual([1.123, 0.5, 0.2]);
    const fine = settled(start, moved(1.123, 0.5, 0), { snap: false, speed: 0.1 }, GRID.home);
    expect(fine.position[0]).toBeCloseTo(0.223);
  });

  it("is drawn to the grid along what was dragged, and to the floor", () => {
    const along = settled(start, moved(0.91, 0.5, 0.03), drawn, GRID.home);
    expect(along.position[0]).toBeCloseTo(0.9);
    expect(along.position[1]).toBe(0.5);
    expect(along.position[2]).toBe(0);
    expect(along.orientation_xyzw).toEqual(start.orientation_xyzw);
    // A table is not a step of a grid.
    expect(settled(start, moved(0.123, 0.5, 0.735), drawn, GRID.home).position[2]).toBe(0.735);
    expect(settled(start, moved(0.123, 0.5, 0.0071), drawn, GRID.hand).position[2]).toBeCloseTo(0.005);
  });

  it("turns to whole steps, and leaves alone what it does not turn", () => {
    const turned = { ...start, orientation_xyzw: orientationFromRpy([0, 0, 0.8]) };
    const [roll, pitch, yaw] = rpyOf(settled(start, turned, drawn, GRID.home).orientation_xyzw);
    expect(roll).toBeCloseTo(0);
    expect(pitch).toBeCloseTo(0);
    expect(yaw).toBeCloseTo(Math.PI / 4);
    expect(settled(start, start, drawn, GRID.home)).toEqual(start);
  });
});
