import { Object3D, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";

import { isFinitePose, place, placePlanar, yawOf, yUpFromZUp, Z_UP_TO_Y_UP, zUpFromYUp } from "./frames";

function close(found: Vector3, x: number, y: number, z: number): void {
  expect(found.distanceTo(new Vector3(x, y, z))).toBeLessThan(1e-12);
}

describe("z up and y up", () => {
  it("turn up into up, forward into right and left into away", () => {
    close(yUpFromZUp(0, 0, 1, new Vector3()), 0, 1, 0);
    close(yUpFromZUp(1, 0, 0, new Vector3()), 1, 0, 0);
    close(yUpFromZUp(0, 1, 0, new Vector3()), 0, 0, -1);
  });

  it("are each other's inverse", () => {
    const point = yUpFromZUp(1.5, -2.5, 3.5, new Vector3());
    close(zUpFromYUp(point.x, point.y, point.z, new Vector3()), 1.5, -2.5, 3.5);
  });

  it("agree with the turn of the group that holds the world", () => {
    const turned = new Vector3(1.5, -2.5, 3.5).applyQuaternion(Z_UP_TO_Y_UP as Quaternion);
    const point = yUpFromZUp(1.5, -2.5, 3.5, new Vector3());
    close(turned, point.x, point.y, point.z);
  });
});

describe("a pose of the wire", () => {
  it("is xyzw: a quarter turn about z takes x to y", () => {
    const object = new Object3D();
    const half = Math.SQRT1_2;
    place(object, { position: [1, 2, 3], orientation_xyzw: [0, 0, half, half] });
    object.updateMatrixWorld();
    close(new Vector3(1, 0, 0).applyMatrix4(object.matrixWorld), 1, 3, 3);
  });

  it("is made a unit quaternion", () => {
    const object = new Object3D();
    place(object, { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 2] });
    expect(object.quaternion.length()).toBeCloseTo(1, 12);
  });

  it("on the floor keeps the height of its object and turns by its yaw", () => {
    const object = new Object3D();
    object.position.z = 0.25;
    for (const yaw of [0, 0.3, -2.9, Math.PI / 2]) {
      placePlanar(object, { x: 4, y: -5, yaw });
      close(object.position, 4, -5, 0.25);
      const { x, y, z, w } = object.quaternion;
      expect(yawOf([x, y, z, w])).toBeCloseTo(yaw, 12);
    }
  });

  it("with a number missing is not finite", () => {
    const good = { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] } as const;
    const pose = (text: string): Parameters<typeof isFinitePose>[0] => JSON.parse(text);
    expect(isFinitePose(pose(JSON.stringify(good)))).toBe(true);
    // JSON has no NaN: it arrives as null.
    const spoilt = JSON.stringify({ ...good, position: [0, Number.NaN, 0] });
    expect(isFinitePose(pose(spoilt))).toBe(false);
  });
});
