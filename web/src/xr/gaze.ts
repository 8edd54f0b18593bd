// Where a person looks who wears a headset, in the map.

import type { Point } from "./map_from_xr";

/** Farther away than this nothing is put down, nor nearer, metres along the floor: within sight and out of the feet. */
const FAR_M = 1.5;
const NEAR_M = 0.5;

/** Where on the floor a person looks whose head is at `head` and who looks along `ahead`; a little ahead if not at it. */
export function lookedAtFrom(head: Point, ahead: Point): [number, number] {
  const level = Math.hypot(ahead[0], ahead[1]);
  if (level < 1e-6) {
    return [head[0], head[1]];
  }
  const down = -ahead[2];
  const reach = down > 1e-6 ? (head[2] / down) * level : FAR_M;
  const distance = Math.min(Math.max(reach, NEAR_M), FAR_M);
  return [head[0] + (distance * ahead[0]) / level, head[1] + (distance * ahead[1]) / level];
}
