// The occupancy grid as a veil just above the floor: what is unknown is covered, what is free is
// bright, what is occupied is dark.

import {
  DataTexture,
  Group,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  PlaneGeometry,
  RGBAFormat,
  SRGBColorSpace,
} from "three";

import { placePlanar } from "../frames";
import { decodeRuns, OCCUPIED, UNKNOWN } from "../grid_runs";
import type { OccupancyMap } from "../protocol";
import type { Rgba, Theme } from "./theme";

const HEIGHT_M = 0.012;
/** Cells from stripe to stripe, and how much of the veil is left between them. */
const HATCH_CELLS = 6;
const HATCH_PART = 0.45;

export class MapLayer {
  readonly root = new Group();
  private mesh: Mesh<PlaneGeometry, MeshBasicMaterial> | null = null;

  constructor() {
    this.root.position.z = HEIGHT_M;
  }

  show(map: OccupancyMap | null, theme: Theme): void {
    this.clear();
    if (map === null || map.width === 0 || map.height === 0) {
      return;
    }
    const cells = decodeRuns(map);
    if (typeof cells === "string") {
      console.warn(cells);
      return;
    }
    const texture = new DataTexture(pixels(cells, map.width, theme), map.width, map.height, RGBAFormat);
    texture.colorSpace = SRGBColorSpace;
    texture.magFilter = NearestFilter;
    texture.minFilter = LinearMipmapLinearFilter;
    texture.generateMipmaps = true;
    texture.needsUpdate = true;
    const [width, height] = [map.width * map.resolution_m, map.height * map.resolution_m];
    // The first row of the texture is the one at the origin, as that of the map.
    const geometry = new PlaneGeometry(width, height).translate(width / 2, height / 2, 0);
    const material = new MeshBasicMaterial({
      map: texture,
      transparent: true,
      depthWrite: false,
      toneMapped: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.renderOrder = 1;
    placePlanar(this.mesh, map.origin);
    this.root.add(this.mesh);
  }

  private clear(): void {
    if (this.mesh !== null) {
      this.root.remove(this.mesh);
      this.mesh.geometry.dispose();
      this.mesh.material.map?.dispose();
      this.mesh.material.dispose();
      this.mesh = null;
    }
  }
}

function pixels(cells: Int8Array, width: number, theme: Theme): Uint8Array<ArrayBuffer> {
  // One colour for each value that a cell can have.
  const table = new Map<number, Rgba>([[UNKNOWN, theme.unknown]]);
  for (let value = 0; value <= OCCUPIED; value++) {
    table.set(value, mix(theme.free, theme.occupied, value / OCCUPIED));
  }
  const bytes = new Uint8Array(4 * cells.length);
  cells.forEach((value, index) => {
    bytes.set(table.get(value) ?? theme.unknown, 4 * index);
    // What is unknown is hatched, so that it does not pass for a shadow.
    const diagonal = (index % width) + Math.floor(index / width);
    if (value === UNKNOWN && diagonal % HATCH_CELLS < HATCH_CELLS / 2) {
      bytes[4 * index + 3] = HATCH_PART * theme.unknown[3];
    }
  });
  return bytes;
}

function mix(a: Rgba, b: Rgba, part: number): Rgba {
  const at = (from: number, to: number): number => Math.round(from + (to - from) * part);
  return [at(a[0], b[0]), at(a[1], b[1]), at(a[2], b[2]), at(a[3], b[3])];
}
