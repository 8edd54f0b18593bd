import { beforeEach, describe, expect, it } from "vitest";

import { Hand, PERIOD_MILLIS, type Push, PUSHES, velocityOf } from "./drive_pad";
import type { Drive } from "./protocol";

function push(name: Push["name"]): Push {
  const found = PUSHES.find((one) => one.name === name);
  if (found === undefined) {
    throw new Error(name);
  }
  return found;
}

describe("a velocity", () => {
  it("is what all pushes wish together, each once", () => {
    expect(velocityOf([])).toEqual({ forward: 0, left: 0, turn: 0 });
    const both = [push("forward"), push("forward"), push("right"), push("turnLeft")];
    expect(velocityOf(both)).toEqual({ forward: 1, left: -1, turn: 1 });
    expect(velocityOf([push("left"), push("right"), push("back")])).toEqual({
      forward: -1,
      left: 0,
      turn: 0,
    });
  });

  it("is never beyond the limits, whatever is held", () => {
    for (let some = 0; some < 1 << PUSHES.length; some++) {
      const velocity = velocityOf(PUSHES.filter((_push, index) => some & (1 << index)));
      expect(Object.values(velocity).every((share) => Math.abs(share) <= 1)).toBe(true);
    }
  });
});

describe("keys that drive", () => {
  it("are none that the page uses otherwise, and none twice", () => {
    const keys = PUSHES.flatMap((one) => one.keys);
    expect(new Set(keys).size).toBe(keys.length);
    for (const taken of [" ", "s", "f", "m", "r", "l", "+", "-", "="]) {
      expect(keys).not.toContain(taken);
    }
  });
});

describe("a hand", () => {
  let said: Drive[];
  let tick: (() => void) | null;
  let hand: Hand;

  beforeEach(() => {
    said = [];
    tick = null;
    hand = new Hand(
      (velocity) => said.push(velocity),
      (callback, millis) => {
        expect(millis).toBe(PERIOD_MILLIS);
        expect(tick).toBeNull();
        tick = callback;
        return () => {
          tick = null;
        };
      },
    );
  });

  it("speaks at once, then with each tick, says that it lets go, and is silent", () => {
    hand.hold("key w", push("forward"));
    tick?.();
    hand.release("key w");
    expect(said.map(({ forward }) => forward)).toEqual([1, 1]);
    tick?.();
    expect(said.map(({ forward }) => forward)).toEqual([1, 1, 0]);
    expect(tick).toBeNull();
  });

  it("does not speak faster when keys go up and down between ticks", () => {
    for (let time = 0; time < 10; time++) {
      hand.hold("key w", push("forward"));
      hand.release("key w");
    }
    expect(said).toHaveLength(1);
    hand.hold("key q", push("turnLeft"));
    tick?.();
    expect(said.at(-1)).toEqual({ forward: 0, left: 0, turn: 1 });
    expect(said).toHaveLength(2);
  });

  it("holds a push until its last source lets go", () => {
    hand.hold("key w", push("forward"));
    hand.hold("pointer 1", push("forward"));
    hand.release("key w");
    tick?.();
    expect(said.at(-1)?.forward).toBe(1);
    hand.releaseAll();
    tick?.();
    expect(said.at(-1)?.forward).toBe(0);
  });
});
