import { describe, expect, it } from "vitest";

import { decodeRuns } from "./grid_runs";
import type { OccupancyMap } from "./protocol";

function map(width: number, height: number, runs: number[]): OccupancyMap {
  return { width, height, resolution_m: 0.05, origin: { x: 0, y: 0, yaw: 0 }, runs };
}

describe("runs of the occupancy grid", () => {
  it("become cells, row by row", () => {
    const cells = decodeRuns(map(3, 2, [-1, 2, 0, 3, 100, 1]));
    expect(cells).toEqual(Int8Array.of(-1, -1, 0, 0, 0, 100));
  });

  it("may be none for a map without cells", () => {
    expect(decodeRuns(map(0, 5, []))).toEqual(new Int8Array(0));
  });

  it.each([
    ["too few cells", map(2, 2, [0, 3]), "map has 3 cells, expected 4"],
    ["too many cells", map(2, 2, [0, 5]), "map has more than its 4 cells"],
    ["a huge count", map(2, 2, [0, 2 ** 31 - 1]), "map has more than its 4 cells"],
    ["no count", map(2, 2, [0, 2, 0]), "map run 1 has count undefined, expected at least 1"],
    ["a count of none", map(2, 2, [0, 0]), "map run 0 has count 0, expected at least 1"],
    ["half a count", map(2, 2, [0, 0.5]), "map run 0 has count 0.5, expected at least 1"],
    ["a high value", map(2, 2, [101, 4]), "map run 0 has value 101, expected -1 to 100"],
    ["a low value", map(2, 2, [-2, 4]), "map run 0 has value -2, expected -1 to 100"],
    ["a negative width", map(-2, 2, [0, 4]), "map is -2 by 2 cells"],
    ["more cells than fit", map(1e6, 1e6, []), "map has 1000000000000 cells, expected at most 64000000"],
  ])("are refused for %s", (_what, broken, problem) => {
    expect(decodeRuns(broken)).toBe(problem);
  });
});
