// Which keys and buttons drive, and what they wish together. A hand on the robot speaks at most ten
// times a second, says once that it has let go, and then nothing.

import type { Drive } from "./protocol";

/** Ten times a second: the studio closes on a page that speaks twice as fast. */
export const PERIOD_MILLIS = 100;

/** A way to push: which share of the velocity it is. */
export interface Push {
  readonly name: "forward" | "back" | "left" | "right" | "turnLeft" | "turnRight";
  readonly axis: keyof Drive;
  readonly sign: 1 | -1;
  /** Keys, as a keyboard event names them in lower case; the first is shown. */
  readonly keys: readonly string[];
}

/** S is the page's Stop, so X is back, as where TurtleBots are driven by keys. */
export const PUSHES: readonly Push[] = [
  { name: "turnLeft", axis: "turn", sign: 1, keys: ["q"] },
  { name: "forward", axis: "forward", sign: 1, keys: ["w", "arrowup"] },
  { name: "turnRight", axis: "turn", sign: -1, keys: ["e"] },
  { name: "left", axis: "left", sign: 1, keys: ["a", "arrowleft"] },
  { name: "back", axis: "forward", sign: -1, keys: ["x", "arrowdown"] },
  { name: "right", axis: "left", sign: -1, keys: ["d", "arrowright"] },
];

const REST: Drive = { forward: 0, left: 0, turn: 0 };

/** The velocity that pushes wish together: opposite ones cancel. */
export function velocityOf(pushes: Iterable<Push>): Drive {
  const wished = { ...REST };
  for (const { axis, sign } of new Set(pushes)) {
    wished[axis] += sign;
  }
  return wished;
}

/**
 * What is held, by its source: a key, a pointer. Speaks through `send` while anything is held.
 * `every` calls back periodically until what it returns is called.
 */
export class Hand {
  private readonly held = new Map<string, Push>();
  private end: (() => void) | null = null;

  constructor(
    private readonly send: (velocity: Drive) => void,
    private readonly every: (callback: () => void, millis: number) => () => void,
  ) {}

  get pushes(): ReadonlySet<Push> {
    return new Set(this.held.values());
  }

  hold(source: string, push: Push): void {
    this.held.set(source, push);
    if (this.end === null) {
      this.end = this.every(() => this.speak(), PERIOD_MILLIS);
      this.speak();
    }
  }

  release(source: string): void {
    this.held.delete(source);
  }

  releaseAll(): void {
    this.held.clear();
  }

  private speak(): void {
    this.send(velocityOf(this.held.values()));
    if (this.held.size === 0) {
      this.end?.();
      this.end = null;
    }
  }
}
