// What a ray points at: the panel before everything else, then what the step is about, then the things of the home, and
// at last the floor.

import { Box3, type Object3D, type Raycaster, Sphere, Vector3 } from "three";

import type { Store } from "../store";
import type { View } from "../view/view";
import type { OnPanel, Panel } from "./panel";

export type Target =
  | { readonly kind: "panel"; readonly at: OnPanel; readonly distance: number }
  | { readonly kind: "thing"; readonly what: "held" | "initiation" | "termination"; readonly distance: number }
  | { readonly kind: "object"; readonly name: string; readonly distance: number }
  | { readonly kind: "world"; readonly distance: number };

/** Farther than this a ray takes hold of nothing, metres. */
const REACH_M = 8;
/** What is missed by less than so many radians is meant: a hand trembles, and a switch is small. */
const NEARLY_RAD = 0.035;
/** Nearer together than this, metres, two things are in the same place. */
const SAME_M = 0.002;
/** Where the world is taken when a ray does not meet the floor, metres along it. */
const NOWHERE_M = 1.5;

export class Pointing {
  private readonly box = new Box3();
  private readonly sphere = new Sphere();
  private readonly one = new Vector3();
  private readonly across = new Vector3();

  constructor(
    private readonly store: Store,
    private readonly view: View,
    private readonly panel: Panel,
  ) {}

  /** What a ray, given in the scene, points at. */
  target(ray: Raycaster): Target {
    const onPanel = this.panel.root.visible ? this.panel.at(ray) : null;
    if (onPanel !== null) {
      return { kind: "panel", at: onPanel, distance: onPanel.distance };
    }
    return this.thing(ray) ?? this.object(ray) ?? { kind: "world", distance: this.floor(ray) };
  }

  /** What is hit, else what is all but hit; of two, that by whose middle the ray passes nearer. */
  private thing(ray: Raycaster): Target | null {
    const graspables = this.view.teach.graspables();
    const best = (met: (nodes: readonly Object3D[]) => number | null): Target | null => {
      let found: Target | null = null;
      let least = Number.POSITIVE_INFINITY;
      for (const { what, nodes } of graspables) {
        const distance = met(nodes);
        if (distance !== null) {
          this.surround(nodes);
          const miss = ray.ray.distanceToPoint(this.box.getCenter(this.one));
          // Two copies may stand in the same place: then what is rather taken comes first.
          if (miss < least - SAME_M) {
            found = { kind: "thing", what, distance };
            least = miss;
          }
        }
      }
      return found;
    };
    return best((nodes) => this.hit(ray, nodes)) ?? best((nodes) => this.nearly(ray, nodes));
  }

  private hit(ray: Raycaster, nodes: readonly Object3D[]): number | null {
    const [first] = ray.intersectObjects([...nodes], true);
    return first !== undefined && first.distance < REACH_M ? first.distance : null;
  }

  /** How far along a ray something is that it just misses. */
  private nearly(ray: Raycaster, nodes: readonly Object3D[]): number | null {
    this.surround(nodes);
    return this.box.isEmpty() ? null : this.past(ray);
  }

  /** The middle of something, in the scene. */
  middleOf(nodes: readonly Object3D[]): Vector3 {
    this.surround(nodes);
    return this.box.getCenter(new Vector3());
  }

  private surround(nodes: readonly Object3D[]): void {
    this.box.makeEmpty();
    for (const node of nodes) {
      this.box.expandByObject(node);
    }
  }

  /** The same of the box. */
  private past(ray: Raycaster): number | null {
    const { center } = this.box.getBoundingSphere(this.sphere);
    const along = this.one.copy(center).sub(ray.ray.origin).dot(ray.ray.direction);
    if (along <= 0 || along > REACH_M) {
      return null;
    }
    const miss = ray.ray.at(along, this.across).distanceTo(center);
    return miss < along * NEARLY_RAD ? along : null;
  }

  /** A thing of the home, where one is chosen. */
  private object(ray: Raycaster): Target | null {
    if (this.store.get("lesson").step !== "overview") {
      return null;
    }
    let best: Target | null = null;
    for (const { name } of this.store.get("teaching")?.objects ?? []) {
      if (this.view.bodies.boxOf(`believed ${name}`, this.box)) {
        const met = ray.ray.intersectBox(this.box, this.across);
        const distance = met === null ? this.past(ray) : met.distanceTo(ray.ray.origin);
        if (distance !== null && distance < REACH_M && (best === null || distance < best.distance)) {
          best = { kind: "object", name, distance };
        }
      }
    }
    return best;
  }

  private floor(ray: Raycaster): number {
    const { origin, direction } = ray.ray;
    // The floor of the scene is where y is zero.
    const distance = direction.y < -1e-3 ? -origin.y / direction.y : NOWHERE_M;
    return distance > 0 && distance < REACH_M ? distance : NOWHERE_M;
  }
}
