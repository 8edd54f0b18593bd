// Where a panel is held before a person, in XR: to the left of what is worked at, turned to the eyes, upright.

import { Quaternion, Vector3 } from "three";

import { composed } from "../frames";
import type { Pose } from "../protocol";

const UP = new Vector3(0, 1, 0);
const AWAY_M = 0.95;
const LEFT_RAD = 0.5;
/** Below the eyes, metres. */
const DROP_M = 0.18;
/** Farther away than this a panel cannot be read: it comes along. */
const OUT_OF_REACH_M = 2.2;

function headingOf(head: Pose): number {
  const ahead = new Vector3(0, 0, -1).applyQuaternion(new Quaternion(...head.orientation_xyzw));
  return Math.atan2(-ahead.x, -ahead.z);
}

export function besidePanel(head: Pose): Pose {
  const turn = new Quaternion().setFromAxisAngle(UP, headingOf(head) + LEFT_RAD);
  const [x, y, z] = head.position;
  return composed(
    { position: [x, y - DROP_M, z], orientation_xyzw: [turn.x, turn.y, turn.z, turn.w] },
    { position: [0, 0, -AWAY_M], orientation_xyzw: [0, 0, 0, 1] },
  );
}

export function isOutOfReach(head: Pose, panel: Pose): boolean {
  return new Vector3(...head.position).distanceTo(new Vector3(...panel.position)) > OUT_OF_REACH_M;
}
