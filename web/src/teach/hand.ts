// How a person likes to drag, from one day to the next.

import type { Hand, Store } from "../store";

const KEY = "factotum.hand";

/** Takes up what was kept, and keeps what is chosen from now on. A browser that keeps nothing does no harm. */
export function keepHand(store: Store, storage: Pick<Storage, "getItem" | "setItem">): void {
  store.handed(recalled(storage));
  store.watch(["hand"], () => {
    try {
      storage.setItem(KEY, JSON.stringify(store.get("hand")));
    } catch {
      // Full, or forbidden.
    }
  });
}

/** What the browser keeps for this page; null where it must not keep anything. */
export function browserStorage(): Storage | null {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

/** What was kept, as far as it makes sense. */
function recalled(storage: Pick<Storage, "getItem">): Partial<Hand> {
  let kept: unknown;
  try {
    kept = JSON.parse(storage.getItem(KEY) ?? "null");
  } catch {
    return {};
  }
  if (typeof kept !== "object" || kept === null) {
    return {};
  }
  const hand: { -readonly [K in keyof Hand]?: Hand[K] } = {};
  if ("snap" in kept && typeof kept.snap === "boolean") {
    hand.snap = kept.snap;
  }
  if ("speed" in kept && typeof kept.speed === "number" && kept.speed >= 0.1 && kept.speed <= 1) {
    hand.speed = kept.speed;
  }
  return hand;
}
