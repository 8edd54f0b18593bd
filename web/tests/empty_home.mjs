// A home of which nothing is known but a map: a room of 4 by 4 metres with a table against the wall.

import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";

const CELLS = 80;

/** Makes a home folder below `dir`; its path. */
export function emptyHome(factotum, dir) {
  const cells = Buffer.alloc(CELLS * CELLS, 254);
  for (let row = 0; row < CELLS; row++) {
    for (let column = 0; column < CELLS; column++) {
      const isWall = Math.min(row, column, CELLS - 1 - row, CELLS - 1 - column) < 2;
      const isTable = row < 14 && column > 30 && column < 50;
      if (isWall || isTable) {
        cells[CELLS * row + column] = 0;
      }
    }
  }
  writeFileSync(join(dir, "room.pgm"), Buffer.concat([Buffer.from(`P5\n${CELLS} ${CELLS}\n255\n`), cells]));
  writeFileSync(
    join(dir, "room.yaml"),
    "image: room.pgm\nresolution: 0.05\norigin: [-2, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
  );
  const home = join(dir, "home");
  execFileSync(factotum, ["map", "import", join(dir, "room.yaml"), "--out", home]);
  return home;
}
