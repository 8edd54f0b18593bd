import { beforeEach, describe, expect, it } from "vitest";

import { type ClientMessage, type Edit, type EditOutcome, type Teaching, VERSION } from "../protocol";
import { Store } from "../store";
import { Edits } from "./edits";

const hello = { type: "hello", version: VERSION, session: "a", client: "a-1", role: "teach" } as const;
const teaching: Teaching = {
  closed: "",
  classes: [],
  objects: [
    {
      name: "flask_1",
      class: "flask",
      pose: { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] },
      provenance: "taught",
      revision: 7,
      colour_index: 0,
    },
  ],
  catalogue: [],
  undo: null,
  redo: null,
  history: [],
  aperture_max_m: 0.1,
};
const remove: Edit = { kind: "remove_object", name: "flask_1" };
const undo: Edit = { kind: "undo" };
const accepted: EditOutcome = { kind: "accepted", entry: 8, what: "flask_1" };

describe("edits", () => {
  let store: Store;
  let sent: ClientMessage[];
  let edits: Edits;
  const answer = (id: string, outcome: EditOutcome): void => store.receive({ type: "edit_answer", id, outcome });

  beforeEach(() => {
    store = new Store();
    sent = [];
    let number = 0;
    edits = new Edits(
      store,
      (message) => sent.push(message) > 0,
      () => `id ${++number}`,
    );
    store.receive(hello);
    store.receive({ type: "teaching", ...teaching });
  });

  it("name the revision that the page shows, and are asked for one after the other", async () => {
    const first = edits.ask(remove);
    const second = edits.ask(undo);
    expect(store.get("unanswered")).toBe(2);
    expect(sent).toEqual([{ type: "edit", id: "id 1", base: 7, edit: remove }]);
    answer("id 1", accepted);
    expect(await first).toEqual(accepted);
    expect(sent[1]).toEqual({ type: "edit", id: "id 2", base: null, edit: undo });
    answer("id 2", { kind: "refused", reason: "there is nothing to undo" });
    expect(await second).toMatchObject({ kind: "refused" });
    expect(store.get("refusal")).toBe("there is nothing to undo");
    expect(store.get("unanswered")).toBe(0);
  });

  it("are asked for again, under the same id, when a lost connection is back", async () => {
    const asked = edits.ask(remove);
    store.connection({ kind: "lost", retryInSecs: 1 });
    store.receive(hello);
    expect(sent).toHaveLength(2);
    expect(sent[1]).toEqual(sent[0]);
    answer("somebody else's", accepted);
    expect(store.get("unanswered")).toBe(1);
    answer("id 1", accepted);
    expect(await asked).toEqual(accepted);
  });

  it("of what is gone lead back to the overview", () => {
    store.learn({ step: "place", object: "flask_1" });
    store.receive({ type: "teaching", ...teaching, objects: [] });
    expect(store.get("lesson")).toEqual({ step: "overview" });
  });
});
