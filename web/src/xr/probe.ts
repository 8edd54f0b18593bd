// What there is to point at in a headset and where, for programs that drive one: tests, and studies at human pace. A
// person sees it; a program asks `window.factotumHeadset`. Nothing can be changed through it.

import type { MapFromXr, Point } from "./map_from_xr";

export interface Seen {
  readonly title: string;
  readonly trail: string;
  readonly body: string;
  readonly values: string;
  readonly notice: string;
  /** The middles of the panel's buttons; all points are in XR, metres. */
  readonly buttons: readonly {
    readonly label: string;
    readonly isDisabled: boolean;
    readonly isPressed: boolean | null;
    readonly at: Point;
  }[];
  /** By which the panel is taken away. */
  readonly head: Point;
  readonly things: readonly { readonly what: string; readonly at: Point }[];
  /** The stand-in of the robot, while it is placed. */
  readonly robot: Point | null;
  readonly mapFromXr: MapFromXr;
  readonly epoch: number;
}

declare global {
  interface Window {
    /** Null while no headset is worn. */
    factotumHeadset?: () => Seen | null;
  }
}

export function showToPrograms(seen: () => Seen | null): void {
  window.factotumHeadset = seen;
}
