// The occupancy grid's run-length code, see `OccupancyMap` in crates/protocol.

import type { OccupancyMap } from "./protocol";

export const UNKNOWN = -1;
export const OCCUPIED = 100;

/** More cells than any home has; keeps a broken message from filling the memory. */
const CELLS_MAX = 64_000_000;

/**
 * The cells, row by row along x from the row at the origin upward in y, or a sentence that says
 * what is wrong with the runs.
 */
export function decodeRuns(map: OccupancyMap): Int8Array | string {
  const { width, height, runs } = map;
  const expected = width * height;
  if (!Number.isInteger(width) || !Number.isInteger(height) || width < 0 || height < 0) {
    return `map is ${width} by ${height} cells`;
  }
  if (expected > CELLS_MAX) {
    return `map has ${expected} cells, expected at most ${CELLS_MAX}`;
  }
  const cells = new Int8Array(expected);
  let at = 0;
  for (let index = 0; index < runs.length; index += 2) {
    const value = runs[index];
    const count = runs[index + 1];
    if (value === undefined || !Number.isInteger(value) || value < UNKNOWN || value > OCCUPIED) {
      return `map run ${index / 2} has value ${value}, expected -1 to 100`;
    }
    if (count === undefined || !Number.isInteger(count) || count < 1) {
      return `map run ${index / 2} has count ${count}, expected at least 1`;
    }
    if (at + count > expected) {
      return `map has more than its ${expected} cells`;
    }
    cells.fill(value, at, at + count);
    at += count;
  }
  return at === expected ? cells : `map has ${at} cells, expected ${expected}`;
}
