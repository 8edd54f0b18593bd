import { describe, expect, it } from "vitest";

import { composed, IDENTITY, orientationFromRpy } from "../frames";
import type { OccupancyMap, Pose } from "../protocol";
import {
  carried,
  firstPlace,
  type MapFromXr,
  mapPoint,
  mapPose,
  poseOfMapFromXr,
  recentred,
  standingAt,
} from "./map_from_xr";

const close = (a: readonly number[], b: readonly number[]): void => {
  expect(a.length).toBe(b.length);
  a.forEach((value, index) => expect(value).toBeCloseTo(b[index] ?? Number.NaN, 9));
};
const somewhere: MapFromXr = { position: [2, -1, 0.1], yaw: 0.8 };

describe("map_from_xr", () => {
  it("looks along the map's y and keeps what is up, at no turn", () => {
    const plain: MapFromXr = { position: [0, 0, 0], yaw: 0 };
    close(mapPoint(plain, [0, 0, -1]), [0, 1, 0]);
    close(mapPoint(plain, [1, 0, 0]), [1, 0, 0]);
    close(mapPoint(plain, [0, 1.6, 0]), [0, 0, 1.6]);
  });

  it("says the same as a pose and as points", () => {
    const xr: Pose = { position: [0.3, 1.2, -0.7], orientation_xyzw: orientationFromRpy([0.1, 0.2, 0.3]) };
    close(mapPose(somewhere, xr).position, mapPoint(somewhere, [0.3, 1.2, -0.7]));
    close(composed(poseOfMapFromXr(somewhere), IDENTITY).position, somewhere.position);
  });

  it("puts a person where they are to stand, looking where they are to look", () => {
    const standing = standingAt({ x: 1, y: 2, yaw: 0 });
    close(mapPoint(standing, [0, 0, 0]), [1, 2, 0]);
    close(mapPoint(standing, [0, 0, -2]), [3, 2, 0]);
  });
});

describe("the world in a hand", () => {
  it("keeps to the hand what it holds, however it is turned", () => {
    const [from, to] = [[0.2, 1, -1], [-0.4, 1.1, -2]] as const;
    const after = carried(somewhere, from, to, 0.5);
    close(mapPoint(after, to), mapPoint(somewhere, from));
    expect(after.yaw).toBeCloseTo(0.3);
  });

  it("turns as the hand does, seen from above", () => {
    const after = carried({ position: [0, 0, 0], yaw: 0 }, [0, 0, 0], [0, 0, 0], Math.PI / 2);
    // What lay ahead (the map's y) has been turned to the left of XR, which is -x.
    close(mapPoint(after, [-1, 0, 0]), [0, 1, 0]);
  });
});

describe("the headset's origin", () => {
  it("may move without the room", () => {
    const oldFromNew: Pose = { position: [0.5, 0, 0.2], orientation_xyzw: [0, Math.sin(0.3), 0, Math.cos(0.3)] };
    const inNew: Pose = { position: [1, 1, -2], orientation_xyzw: [0, 0, 0, 1] };
    const after = recentred(somewhere, oldFromNew);
    close(mapPoint(after, [1, 1, -2]), mapPose(somewhere, composed(oldFromNew, inNew)).position);
  });
});

describe("the first place", () => {
  const map = { origin: { x: -2, y: -2, yaw: 0 }, width: 80, height: 60, resolution_m: 0.05 } as OccupancyMap;

  it("is behind the robot", () => {
    expect(firstPlace({ x: 1, y: 1, yaw: Math.PI / 2 }, map).y).toBeCloseTo(-0.2);
  });

  it("is inside the edge of the map, looking into it", () => {
    const { x, y, yaw } = firstPlace(null, map);
    close([x, y, yaw], [0, -1.7, Math.PI / 2]);
    const turned = firstPlace(null, { ...map, origin: { x: 0, y: 0, yaw: Math.PI / 2 } });
    close([turned.x, turned.y, turned.yaw], [-0.3, 2, Math.PI]);
  });

  it("is at the origin where there is nothing", () => {
    close(Object.values(firstPlace(null, null)), [0, 0, Math.PI / 2]);
  });
});
