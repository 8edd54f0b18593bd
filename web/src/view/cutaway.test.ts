import { BoxGeometry, Group, Mesh, Vector3 } from "three";
import { describe, expect, it } from "vitest";

import { Z_UP_TO_Y_UP } from "../frames";
import type { Geometry } from "../protocol";
import { Cutaway } from "./cutaway";

const TARGET = new Vector3(0, 0, 0);
/** Long enough for a wall to come to rest. */
const SECS = 10;

/** A box in the wire's world, y being the thin way of a wall, one metre to the right of the target. */
function boxAt(size: [number, number, number], bottom: number): { cutaway: Cutaway; mesh: Mesh } {
  const world = new Group();
  world.quaternion.copy(Z_UP_TO_Y_UP);
  const body = new Group();
  const mesh = new Mesh(new BoxGeometry());
  mesh.scale.set(...size);
  mesh.position.set(0, -1, bottom + size[2] / 2);
  body.add(mesh);
  body.updateMatrixWorld(true);
  const half: Geometry = { kind: "box", half_extents_m: [size[0] / 2, size[1] / 2, size[2] / 2] };
  const cutaway = new Cutaway();
  cutaway.consider(mesh, half);
  world.add(body);
  world.updateMatrixWorld(true);
  return { cutaway, mesh };
}

/** Top and bottom of the box, in metres above the floor. */
function extent(mesh: Mesh): [number, number] {
  return [mesh.position.z - mesh.scale.z / 2, mesh.position.z + mesh.scale.z / 2];
}

describe("a wall", () => {
  it("goes down when it stands before the target and comes up again", () => {
    const { cutaway, mesh } = boxAt([4, 0.1, 2.5], 0);
    // One metre to the right in the wire is z = 1 here.
    expect(cutaway.update(new Vector3(0, 3, 5), TARGET, SECS)).toBe(true);
    expect(extent(mesh)[0]).toBeCloseTo(0, 9);
    expect(extent(mesh)[1]).toBeLessThan(0.2);
    expect(cutaway.update(new Vector3(0, 3, 5), TARGET, SECS)).toBe(false);
    cutaway.update(new Vector3(0, 3, -5), TARGET, SECS);
    expect(extent(mesh)[1]).toBeCloseTo(2.5, 9);
  });

  it("that is a lintel vanishes", () => {
    const { cutaway, mesh } = boxAt([1, 0.1, 0.4], 2.1);
    cutaway.update(new Vector3(0, 3, 5), TARGET, SECS);
    expect(mesh.visible).toBe(false);
  });

  it.each([
    ["a table", [1, 0.6, 0.7]],
    ["a fridge", [0.7, 0.7, 1.8]],
    ["a low board", [2, 0.05, 1]],
  ] as const)("is not %s", (_what, [x, y, z]) => {
    const { cutaway, mesh } = boxAt([x, y, z], 0);
    expect(cutaway.update(new Vector3(0, 3, 5), TARGET, SECS)).toBe(false);
    expect(mesh.scale.z).toBe(z);
  });
});
