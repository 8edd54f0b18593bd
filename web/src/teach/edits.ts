// Edits on their way to the studio, one after the other, until each is answered.
//
// An edit that was sent when the connection broke is sent again, under the same id, when it is back: the studio applies
// it once. Each names the revision of its class or object as this page shows it, so that nobody's change is overwritten
// unseen.

import type { ClientMessage, Edit, EditOutcome, EditRequest, Teaching } from "../protocol";
import type { Store } from "../store";

interface Waiting {
  readonly edit: Edit;
  readonly resolve: (outcome: EditOutcome) => void;
  request: EditRequest | null;
}

export class Edits {
  private readonly waiting: Waiting[] = [];

  constructor(
    private readonly store: Store,
    private readonly send: (message: ClientMessage) => boolean,
    private readonly newId: () => string = randomId,
  ) {
    store.watch(["answer"], () => this.hear());
    store.watch(["connection"], () => {
      // What was sent on a connection that has ended may not have arrived.
      if (store.get("connection").kind === "open") {
        this.sendFirst();
      }
    });
  }

  /** Asks for an edit; resolves when the studio has answered, which it does in the order of asking. */
  ask(edit: Edit): Promise<EditOutcome> {
    return new Promise((resolve) => {
      this.waiting.push({ edit, resolve, request: null });
      if (this.waiting.length === 1) {
        this.sendFirst();
      }
      this.store.edits(this.waiting.length, "");
    });
  }

  private sendFirst(): void {
    const first = this.waiting[0];
    if (first !== undefined) {
      first.request ??= {
        id: this.newId(),
        base: revisionOf(first.edit, this.store.get("teaching")),
        edit: first.edit,
      };
      this.send({ type: "edit", ...first.request });
    }
  }

  private hear(): void {
    const answer = this.store.get("answer");
    const first = this.waiting[0];
    if (answer === null || first === undefined || answer.id !== first.request?.id) {
      return;
    }
    this.waiting.shift();
    const { outcome } = answer;
    this.store.edits(this.waiting.length, outcome.kind === "refused" ? outcome.reason : "");
    first.resolve(outcome);
    this.sendFirst();
  }
}

/** The revision of what an edit changes; null for what is new. */
export function revisionOf(edit: Edit, teaching: Teaching | null): number | null {
  const find = (list: readonly { name: string; revision: number }[] | undefined, name: string): number | null =>
    list?.find((thing) => thing.name === name)?.revision ?? null;
  switch (edit.kind) {
    case "reshape_class":
    case "remove_class":
      return find(teaching?.classes, edit.name);
    case "put_grasp":
    case "remove_grasp":
    case "put_action":
    case "remove_action":
      return find(teaching?.classes, edit.class);
    case "move_object":
    case "rename_object":
    case "remove_object":
      return find(teaching?.objects, edit.name);
    case "make_class":
    case "take_class":
    case "add_object":
    case "undo":
    case "redo":
      return null;
  }
}

function randomId(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
