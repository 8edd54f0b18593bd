// Where a headset's space lies in the map: `map_from_xr`.
//
// XR is the headset's `local-floor` space: metres, y up, -z ahead of the person when the session began, the origin on the
// floor. Both spaces know what is upright, so all that can be wrong is where the origin is and how it is turned about the
// upright: no tilt.

import { Quaternion, Vector3 } from "three";

import { composed, Z_UP_TO_Y_UP, zUpFromYUp } from "../frames";
import type { OccupancyMap, Pose, PosePlanar } from "../protocol";

export type Point = readonly [number, number, number];

export interface MapFromXr {
  /** XR's origin in the map, metres. */
  readonly position: Point;
  /** Turn about the map's z, radians; at 0 the person looks along the map's y. */
  readonly yaw: number;
}

/** Why the two lie as they do, for people. */
export type AlignedBy = "placed" | "moved" | "robot" | "recentred" | "lost";

export interface Alignment {
  readonly mapFromXr: MapFromXr;
  /** Counts the changes: what was seen under another number was seen elsewhere. */
  readonly epoch: number;
  readonly by: AlignedBy;
}

const UPRIGHT = new Vector3(0, 0, 1);

/** As a pose, which also turns y up into z up. */
export function poseOfMapFromXr({ position, yaw }: MapFromXr): Pose {
  const turn = new Quaternion().setFromAxisAngle(UPRIGHT, yaw);
  turn.multiply(new Quaternion().copy(Z_UP_TO_Y_UP).invert());
  return { position: [...position], orientation_xyzw: [turn.x, turn.y, turn.z, turn.w] };
}

/** A pose of XR in the map. */
export function mapPose(mapFromXr: MapFromXr, xrPose: Pose): Pose {
  return composed(poseOfMapFromXr(mapFromXr), xrPose);
}

/** A point of XR in the map. */
export function mapPoint({ position, yaw }: MapFromXr, [x, y, z]: Point): [number, number, number] {
  const at = zUpFromYUp(x, y, z, new Vector3()).applyAxisAngle(UPRIGHT, yaw);
  return [position[0] + at.x, position[1] + at.y, position[2] + at.z];
}

/** A person stands on the floor, with the headset's origin under the feet, and looks in a direction of the map. */
export function standingAt({ x, y, yaw }: PosePlanar): MapFromXr {
  return { position: [x, y, 0], yaw: yaw - Math.PI / 2 };
}

/**
 * The world has been taken by a point of XR and carried to another, and turned about the upright there, by `turn` radians
 * as seen in XR. Whoever puts the virtual robot over the real one so calibrates.
 */
export function carried(before: MapFromXr, from: Point, to: Point, turn: number): MapFromXr {
  const yaw = before.yaw - turn;
  const held = mapPoint(before, from);
  const [x, y, z] = mapPoint({ position: [0, 0, 0], yaw }, to);
  return { position: [held[0] - x, held[1] - y, held[2] - z], yaw };
}

/** The headset has moved its own origin: nothing in the room has moved. */
export function recentred(before: MapFromXr, oldFromNew: Pose): MapFromXr {
  const [x, y, z, w] = oldFromNew.orientation_xyzw;
  // About the upright of XR, which is y.
  const turn = Math.atan2(2 * (w * y + x * z), 1 - 2 * (x * x + y * y));
  return { position: mapPoint(before, oldFromNew.position), yaw: before.yaw + turn };
}

/** How far from a robot a person stands at first, metres: out of its reach. */
const BEHIND_ROBOT_M = 1.2;

/** How far from the edge of a map a person stands at first, metres: inside of the walls that are often there. */
const INSIDE_M = 0.3;

/** Where a person stands at first: behind the robot, else at the edge of the map, and looks at it. */
export function firstPlace(robot: PosePlanar | null, map: OccupancyMap | null): PosePlanar {
  if (robot !== null) {
    const { x, y, yaw } = robot;
    return { x: x - BEHIND_ROBOT_M * Math.cos(yaw), y: y - BEHIND_ROBOT_M * Math.sin(yaw), yaw };
  }
  if (map === null) {
    return { x: 0, y: 0, yaw: Math.PI / 2 };
  }
  // By the middle of the side at which y begins, looking along y.
  const { origin, width, resolution_m } = map;
  const half = 0.5 * width * resolution_m;
  const [cos, sin] = [Math.cos(origin.yaw), Math.sin(origin.yaw)];
  return {
    x: origin.x + half * cos - INSIDE_M * sin,
    y: origin.y + half * sin + INSIDE_M * cos,
    yaw: origin.yaw + Math.PI / 2,
  };
}
