import { describe, expect, it } from "vitest";

import { Store } from "../store";
import { keepHand } from "./hand";

function storageOf(text: string | null): Pick<Storage, "getItem" | "setItem"> & { text: string | null } {
  return {
    text,
    getItem() {
      return this.text;
    },
    setItem(_key, value) {
      this.text = value;
    },
  };
}

describe("how a person likes to drag", () => {
  it("is kept", () => {
    const storage = storageOf(null);
    const store = new Store();
    keepHand(store, storage);
    store.handed({ speed: 0.3, snap: false });
    const another = new Store();
    keepHand(another, storage);
    expect(another.get("hand")).toEqual({ mode: "move", snap: false, speed: 0.3 });
  });

  it("is what it was where nonsense was kept", () => {
    for (const text of ["{", "7", "null", '{"speed":9,"snap":"yes"}']) {
      const store = new Store();
      keepHand(store, storageOf(text));
      expect(store.get("hand")).toEqual({ mode: "move", snap: true, speed: 1 });
    }
  });
});
