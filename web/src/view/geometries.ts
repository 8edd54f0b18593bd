// The wire's geometries as three.js geometries. Most are one unit geometry, scaled by the mesh
// that shows it, so that a home of a thousand boxes uploads one.

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  CylinderGeometry,
  EdgesGeometry,
  PlaneGeometry,
  SphereGeometry,
  Vector3,
} from "three";
import { toCreasedNormals } from "three/addons/utils/BufferGeometryUtils.js";

import type { Geometry } from "../protocol";

/** A geometry and the scale at which a mesh has to show it. */
export interface Shown {
  readonly geometry: BufferGeometry;
  readonly scale: Vector3;
  /** Lines along its edges, where it has any worth drawing. */
  readonly edges: BufferGeometry | null;
}

/** Faces that meet at less than this look like one. */
const CREASE_RAD = 0.6;

const UNIT = new Vector3(1, 1, 1);
const box = new BoxGeometry(1, 1, 1);
const boxEdges = new EdgesGeometry(box);
const sphere = new SphereGeometry(1, 32, 20);
// three.js has round geometries stand along y, the wire along z.
const cylinder = new CylinderGeometry(1, 1, 1, 40).rotateX(Math.PI / 2);
const cylinderEdges = new EdgesGeometry(cylinder, 30);
const plane = new PlaneGeometry(1, 1);
const capsules = new Map<string, BufferGeometry>();

/** What to show for a geometry; null for one without end, which the ground stands for. */
export function shown(geometry: Geometry): Shown | null {
  switch (geometry.kind) {
    case "box": {
      const scale = new Vector3(...geometry.half_extents_m).multiplyScalar(2);
      return { geometry: box, scale, edges: boxEdges };
    }
    case "sphere":
      return { geometry: sphere, scale: new Vector3().setScalar(geometry.radius_m), edges: null };
    case "ellipsoid":
      return { geometry: sphere, scale: new Vector3(...geometry.radii_m), edges: null };
    case "cylinder": {
      const { radius_m, half_length_m } = geometry;
      const scale = new Vector3(radius_m, radius_m, 2 * half_length_m);
      return { geometry: cylinder, scale, edges: cylinderEdges };
    }
    case "capsule":
      return { geometry: capsule(geometry.radius_m, geometry.half_length_m), scale: UNIT, edges: null };
    case "plane": {
      const [x, y] = geometry.half_extents_m;
      if (x <= 0 || y <= 0) {
        return null;
      }
      return { geometry: plane, scale: new Vector3(2 * x, 2 * y, 1), edges: null };
    }
    case "mesh":
      return { geometry: mesh(geometry.vertices, geometry.triangles), scale: UNIT, edges: null };
  }
}

/** Whether a geometry is shared, and so outlives the scene that shows it. */
export function isShared(geometry: BufferGeometry): boolean {
  return geometry.userData["own"] !== true;
}

function capsule(radius: number, halfLength: number): BufferGeometry {
  const key = `${radius}/${halfLength}`;
  let made = capsules.get(key);
  if (made === undefined) {
    made = new CapsuleGeometry(radius, 2 * halfLength, 10, 28).rotateX(Math.PI / 2);
    capsules.set(key, made);
  }
  return made;
}

function mesh(vertices: readonly number[], triangles: readonly number[]): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(vertices), 3));
  const n_vertices = Math.floor(vertices.length / 3);
  // A triangle with a vertex that is not there would be read from outside the buffer.
  const inside = triangles.every((vertex) => vertex < n_vertices);
  geometry.setIndex(inside ? [...triangles] : []);
  const creased = toCreasedNormals(geometry, CREASE_RAD);
  creased.userData["own"] = true;
  return creased;
}
