// Where the base is, where it is about to drive, and where it has been.

import {
  BufferAttribute,
  BufferGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  RingGeometry,
  Shape,
  ShapeGeometry,
} from "three";

import { placePlanar } from "../frames";
import type { BasePath, State } from "../protocol";
import type { Theme } from "./theme";

const HEIGHT_M = 0.03;
const PATH_WIDTH_M = 0.05;
const TRAIL_WIDTH_M = 0.02;
const TRAIL_STEP_M = 0.06;
const TRAIL_POINTS_MAX = 1500;
/** Farther than a robot drives between two states: it was put there. */
const TRAIL_JUMP_M = 1;
const RING_INNER_M = 0.46;
const RING_OUTER_M = 0.49;

export class PathLayer {
  readonly root = new Group();
  private readonly ahead = flat(0.95);
  private readonly behind = flat(0.4);
  private readonly base = new Group();
  private readonly baseMaterial = flatMaterial(0.9);
  private trail: [number, number][] = [];

  constructor() {
    this.root.position.z = HEIGHT_M;
    const nose = new Shape();
    nose.moveTo(RING_OUTER_M + 0.13, 0);
    nose.lineTo(RING_OUTER_M + 0.02, 0.08);
    nose.lineTo(RING_OUTER_M + 0.02, -0.08);
    nose.closePath();
    for (const geometry of [
      new RingGeometry(RING_INNER_M, RING_OUTER_M, 64),
      new ShapeGeometry(nose),
    ]) {
      const mesh = new Mesh(geometry, this.baseMaterial);
      mesh.renderOrder = 4;
      this.base.add(mesh);
    }
    this.base.visible = false;
    this.root.add(this.behind, this.ahead, this.base);
  }

  showPath(path: BasePath | null): void {
    replaceGeometry(this.ahead, ribbon(path?.points ?? [], PATH_WIDTH_M));
  }

  /** Follows the base. Allocates only when the trail grows. */
  showBase(state: State | null): void {
    this.base.visible = state !== null && Number.isFinite(state.base.x + state.base.y);
    if (state === null) {
      this.trail = [];
      replaceGeometry(this.behind, ribbon([], TRAIL_WIDTH_M));
      return;
    }
    if (!this.base.visible) {
      return;
    }
    placePlanar(this.base, state.base);
    const last = this.trail.at(-1);
    const step =
      last === undefined ? Infinity : Math.hypot(state.base.x - last[0], state.base.y - last[1]);
    if (step < TRAIL_STEP_M) {
      return;
    }
    if (step > TRAIL_JUMP_M) {
      this.trail = [];
    }
    this.trail.push([state.base.x, state.base.y]);
    if (this.trail.length > TRAIL_POINTS_MAX) {
      this.trail.splice(0, TRAIL_POINTS_MAX / 3);
    }
    replaceGeometry(this.behind, ribbon(this.trail, TRAIL_WIDTH_M));
  }

  setTheme(theme: Theme): void {
    for (const material of [this.ahead.material, this.behind.material, this.baseMaterial]) {
      material.color.set(theme.accent);
    }
  }
}

type Flat = Mesh<BufferGeometry, MeshBasicMaterial>;

function flatMaterial(opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ transparent: true, opacity, depthWrite: false, toneMapped: false });
}

function flat(opacity: number): Flat {
  const mesh = new Mesh(new BufferGeometry(), flatMaterial(opacity));
  mesh.renderOrder = 3;
  mesh.frustumCulled = false;
  return mesh;
}

function replaceGeometry(mesh: Flat, geometry: BufferGeometry): void {
  mesh.geometry.dispose();
  mesh.geometry = geometry;
}

/** A band along a line, flat on the floor, mitred at its corners. */
export function ribbon(points: readonly (readonly [number, number])[], width: number): BufferGeometry {
  const geometry = new BufferGeometry();
  if (points.length < 2) {
    return geometry;
  }
  const positions = new Float32Array(6 * points.length);
  const indices: number[] = [];
  points.forEach((point, index) => {
    const before = points[index - 1] ?? point;
    const after = points[index + 1] ?? point;
    const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
    const length = Math.hypot(dx, dy) || 1;
    const [nx, ny] = [(-dy / length) * (width / 2), (dx / length) * (width / 2)];
    positions.set([point[0] + nx, point[1] + ny, 0, point[0] - nx, point[1] - ny, 0], 6 * index);
    if (index > 0) {
      const at = 2 * index;
      indices.push(at - 2, at - 1, at, at - 1, at + 1, at);
    }
  });
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setIndex(indices);
  return geometry;
}
