// What a dragged pose settles to: slowed down for fine work, and drawn to the floor and to a grid.

import { Quaternion, Vector3 } from "three";

import { orientationFromRpy, rpyOf } from "../frames";
import type { Pose } from "../protocol";

export interface Settling {
  readonly snap: boolean;
  /** Share of the hand's way, 0 to 1. */
  readonly speed: number;
}

/** Steps to which poses are drawn: metres and radians. */
export const GRID = {
  /** Of objects, on the floor. */
  home: { step: 0.05, turn: Math.PI / 12, floor: 0.04 },
  /** Of a gripper at an object. */
  hand: { step: 0.005, turn: Math.PI / 36, floor: 0 },
} as const;

export type Grid = (typeof GRID)[keyof typeof GRID];

/** Where a pose that was dragged from `start` to `wanted` goes. */
export function settled(start: Pose, wanted: Pose, { snap, speed }: Settling, grid: Grid): Pose {
  const at = new Vector3(...start.position).lerp(new Vector3(...wanted.position), speed);
  const turned = new Quaternion(...start.orientation_xyzw).slerp(
    new Quaternion(...wanted.orientation_xyzw),
    speed,
  );
  const pose: Pose = {
    position: [at.x, at.y, at.z],
    orientation_xyzw: [turned.x, turned.y, turned.z, turned.w],
  };
  return snap ? snapped(start, pose, grid) : pose;
}

/** Only what was changed is drawn to the grid: a drag along x does not move a thing along y. */
function snapped(start: Pose, pose: Pose, grid: Grid): Pose {
  const [x, y, z] = pose.position.map((value, axis) => {
    const before = start.position[axis] ?? value;
    if (Math.abs(value - before) < 1e-9) {
      return before;
    }
    // Upwards there are tables and shelves of all heights, but one floor.
    if (axis === 2 && grid.floor > 0) {
      return Math.abs(value) < grid.floor ? 0 : value;
    }
    return rounded(value, grid.step);
  }) as [number, number, number];
  const before = new Quaternion(...start.orientation_xyzw);
  const isTurned = before.angleTo(new Quaternion(...pose.orientation_xyzw)) > 1e-6;
  const [roll, pitch, yaw] = rpyOf(pose.orientation_xyzw).map((angle) => rounded(angle, grid.turn)) as [
    number,
    number,
    number,
  ];
  return {
    position: [x, y, z],
    orientation_xyzw: isTurned ? orientationFromRpy([roll, pitch, yaw]) : start.orientation_xyzw,
  };
}

function rounded(value: number, step: number): number {
  return Math.round(value / step) * step;
}
