// The hands of a person as the headset tells of them: up to four rays, each of which points, holds and lets go.
//
// Controllers, hands and eyes (transient pointers) come as the same `select` events; which it is makes no difference to
// what is pointed at. A transient pointer is there only while it holds.

import {
  type Group,
  type Object3D,
  Raycaster,
  Vector3,
  type WebXRManager,
  type WebXRSpaceEventMap,
  type XRTargetRaySpace,
} from "three";

import { poseOf } from "../frames";
import type { Pose } from "../protocol";
import { Beam, controllerHandle, knuckles } from "./hands";

/** Two controllers and two hands, or two hands and two eyes' pointers. */
const RAYS = 4;

export type Press = "select" | "squeeze";

export interface RayEvents {
  pressed(ray: Ray, press: Press): void;
  released(ray: Ray, press: Press): void;
}

export class Ray {
  /** Where it comes from and points to, in the scene. */
  readonly caster = new Raycaster();
  isSelecting = false;
  private isConnected = false;
  private readonly beam: Beam;
  private handle: Object3D | null = null;
  private readonly direction = new Vector3();
  private readonly origin = new Vector3();

  constructor(
    private readonly group: XRTargetRaySpace,
    private readonly hand: Group,
    colour: number,
    seesRoom: boolean,
    events: RayEvents,
  ) {
    this.beam = new Beam(colour);
    // The manager's groups outlive a session: what is put below them, and heard of them, is taken away with it.
    this.group.add(...this.beam.parts);
    this.on("connected", ({ data }) => {
      this.isConnected = true;
      if (data.hand == null && !seesRoom && data.targetRayMode === "tracked-pointer") {
        this.handle = controllerHandle();
        this.group.add(this.handle);
      }
    });
    this.on("disconnected", () => {
      // What it held is let go where it is.
      this.release(events);
      events.released(this, "squeeze");
      this.isConnected = false;
      this.handle?.removeFromParent();
    });
    this.on("selectstart", () => {
      this.isSelecting = true;
      this.aim();
      events.pressed(this, "select");
    });
    this.on("selectend", () => this.release(events));
    this.on("squeezestart", () => {
      this.aim();
      events.pressed(this, "squeeze");
    });
    this.on("squeezeend", () => events.released(this, "squeeze"));
  }

  private readonly forget: (() => void)[] = [];

  private on<K extends keyof WebXRSpaceEventMap>(type: K, run: (event: WebXRSpaceEventMap[K]) => void): void {
    this.group.addEventListener(type, run);
    this.forget.push(() => this.group.removeEventListener(type, run));
  }

  private release(events: RayEvents): void {
    if (this.isSelecting) {
      this.isSelecting = false;
      events.released(this, "select");
    }
  }

  /** It is there, and the headset knows where. */
  get isTracked(): boolean {
    return this.isConnected && this.group.visible;
  }

  /** The ray in XR: it points along its -z. */
  xrFromRay(): Pose {
    this.group.matrix.decompose(this.group.position, this.group.quaternion, this.group.scale);
    return poseOf(this.group);
  }

  /** Takes up where it is now. Allocates nothing. */
  aim(): void {
    this.group.updateWorldMatrix(true, false);
    this.origin.setFromMatrixPosition(this.group.matrixWorld);
    this.direction.set(0, 0, -1).transformDirection(this.group.matrixWorld);
    this.caster.set(this.origin, this.direction);
    knuckles(this.hand);
  }

  /** Shows how far it reaches. */
  reach(distance: number, holds: boolean): void {
    this.beam.reach(distance, holds);
  }

  dispose(): void {
    for (const one of this.forget) {
      one();
    }
    for (const part of [...this.beam.parts, this.handle]) {
      part?.removeFromParent();
    }
    this.beam.dispose();
  }
}

/** The rays of a session, below `origin`, which is XR's origin in the scene. Hands are drawn where the room is not seen. */
export function rays(
  xr: WebXRManager,
  origin: Object3D,
  look: { readonly colour: number; readonly seesRoom: boolean },
  events: RayEvents,
): Ray[] {
  return Array.from({ length: RAYS }, (_, index) => {
    const group = xr.getController(index);
    const hand = xr.getHand(index);
    origin.add(group);
    if (look.seesRoom) {
      hand.removeFromParent();
    } else {
      origin.add(hand);
    }
    return new Ray(group, hand, look.colour, look.seesRoom, events);
  });
}
