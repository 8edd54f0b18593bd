// Navigation symbols grounded in this home: for each base pose a disc with a nose that points
// where the robot would look, in the region's colour.

import {
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  MeshBasicMaterial,
  Object3D,
  Shape,
  ShapeGeometry,
} from "three";

import { regionColour } from "../palette";
import type { NavigationRegion } from "../protocol";

const HEIGHT_M = 0.018;
/** Lets two regions at one place both be seen. */
const HEIGHT_STEP_M = 0.0015;
const RADIUS_M = 0.055;
const NOSE_M = 0.13;

export class RegionsLayer {
  readonly root = new Group();
  private readonly geometry = marker();
  private readonly scratch = new Object3D();

  show(regions: readonly NavigationRegion[]): void {
    for (const child of [...this.root.children]) {
      this.root.remove(child);
      if (child instanceof InstancedMesh) {
        child.dispose();
      }
    }
    regions.forEach((region, index) => {
      this.root.add(this.region(region, HEIGHT_M + index * HEIGHT_STEP_M));
    });
  }

  private region(region: NavigationRegion, height: number): InstancedMesh {
    const material = new MeshBasicMaterial({
      color: regionColour(region.colour_index),
      transparent: true,
      opacity: 0.78,
      depthWrite: false,
      toneMapped: false,
    });
    const mesh = new InstancedMesh(this.geometry, material, region.poses.length);
    mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    mesh.renderOrder = 2;
    region.poses.forEach(([x, y, yaw], index) => {
      this.scratch.position.set(x, y, height);
      this.scratch.rotation.set(0, 0, yaw);
      this.scratch.updateMatrix();
      mesh.setMatrixAt(index, this.scratch.matrix);
    });
    mesh.computeBoundingSphere();
    return mesh;
  }
}

/** Where to write a region's number: in the middle of its poses. */
export function centreOf(region: NavigationRegion): [number, number] | null {
  const n = region.poses.length;
  if (n === 0) {
    return null;
  }
  const sum = region.poses.reduce<[number, number]>(([x, y], pose) => [x + pose[0], y + pose[1]], [0, 0]);
  return [sum[0] / n, sum[1] / n];
}

/** A disc with a nose along x. */
function marker(): ShapeGeometry {
  // Where the tangents from the tip of the nose touch the disc.
  const touch = Math.acos(RADIUS_M / NOSE_M);
  const outline = new Shape();
  outline.moveTo(NOSE_M, 0);
  outline.lineTo(RADIUS_M * Math.cos(touch), RADIUS_M * Math.sin(touch));
  outline.absarc(0, 0, RADIUS_M, touch, 2 * Math.PI - touch, false);
  outline.closePath();
  return new ShapeGeometry(outline, 16);
}
