import { describe, expect, it } from "vitest";

import { IDENTITY } from "../frames";
import { type ClientMessage, type Edit, type Role, type TaughtClass, type Teaching, VERSION } from "../protocol";
import { Store } from "../store";
import type { Desk } from "../teach/desk";
import { Edits } from "../teach/edits";
import { firstGrasp } from "../teach/lesson";
import type { Menu } from "./menu";
import { type Placed, placed, SHEET, TEXT_END_PX } from "./menu_layout";
import { Menus } from "./menus";

const bin: TaughtClass = {
  name: "bin",
  description: "",
  provenance: "taught",
  revision: 1,
  movable: false,
  form: { kind: "box", size_m: [0.3, 0.3, 0.33] },
  parts: [],
  joints: [],
  states: [],
  grasps: [],
  actions: [],
};
const flask: TaughtClass = { ...bin, name: "flask", movable: true, form: { kind: "cylinder", diameter_m: 0.06, height_m: 0.2 } };
const tap: TaughtClass = {
  ...bin,
  name: "tap",
  form: null,
  joints: [
    { name: "handle", kind: "revolute", axis: [0, 0, 1], origin: [0, 0, 0], range: [0, 1.3] },
    { name: "spout", kind: "revolute", axis: [0, 0, 1], origin: [0, 0, 0], range: [-1, 1] },
  ],
  states: [{ name: "open", joint: "handle", range: [0.6, 1.35] }],
};
const teaching: Teaching = {
  closed: "",
  classes: [bin, flask, tap],
  objects: ["bin", "flask", "tap"].map((name, index) => ({
    name: `${name}_1`,
    class: name,
    pose: IDENTITY,
    provenance: "taught",
    revision: 1,
    colour_index: index,
  })),
  catalogue: [{ name: "door", description: "" }],
  undo: "move flask_1",
  redo: null,
  history: [],
  aperture_max_m: 0.1,
};

class Worn {
  readonly store = new Store();
  readonly edits: Edit[] = [];
  readonly menus: Menus;
  isAligning = false;
  hasLeft = false;

  constructor(of: Teaching | null = teaching, role: Role = "teach") {
    this.store.receive({ type: "hello", version: VERSION, session: "a", client: "a-1", role });
    if (of !== null) {
      this.store.receive({ type: "teaching", ...of });
    }
    const send = (message: ClientMessage): boolean => {
      if (message.type === "edit") {
        this.edits.push(message.edit);
      }
      return true;
    };
    const desk: Desk = { store: this.store, edits: new Edits(this.store, send), lookedAt: () => [0.51, 1] };
    this.menus = new Menus(
      desk,
      {
        leave: () => {
          this.hasLeft = true;
        },
        isAligning: () => this.isAligning,
        align: (isAligning) => {
          this.isAligning = isAligning;
        },
        hasRobot: () => false,
      },
      () => {},
    );
  }

  get menu(): Menu {
    return this.menus.menu();
  }

  get labels(): string[] {
    return [...this.menu.list, ...this.menu.rows.flat()].map(({ label }) => label);
  }

  press(label: string): void {
    const found = [...this.menu.list, ...this.menu.rows.flat()].find((button) => button.label === label);
    if (found === undefined) {
      throw new Error(`no button "${label}" among ${this.labels.join(", ")}`);
    }
    expect(found.isDisabled ?? false).toBe(false);
    found.run();
  }
}

describe("the menus", () => {
  it("go through all steps of a thing, asking for the edits that the page asks for", () => {
    const worn = new Worn();
    worn.press("Teach a new thing");
    expect(worn.menu.trail).toBe("1 of 4: What");
    worn.press("flask");
    expect(worn.edits).toMatchObject([{ kind: "add_object", class: "flask", pose: { position: [0.5, 1, 0] } }]);
    worn.press("Back");
    worn.press("flask 1");
    expect(worn.menu.title).toBe("Where is flask 1?");
    worn.press("Next");
    worn.press("Show a way to hold it");
    worn.press("Begin above it");
    worn.press("Opening +");
    expect(worn.store.get("draft").grasp?.aperture_m).toBe(0.1);
    worn.press("Leave it");
    worn.press("Next");
    worn.press("Put it into something");
    expect(worn.store.get("draft").action).toMatchObject({ name: "put_in_bin", motion: { class: "bin" } });
    worn.press("Into: bin");
    expect(worn.store.get("draft").action).toMatchObject({ motion: { class: "tap" } });
    worn.press("Leave it");
    worn.press("Finish");
    expect(worn.menu.title).toBe("Your home");
  });

  it("tell an action with a part, which is not saved before it has a name", () => {
    const worn = new Worn();
    worn.store.learn({ step: "actions", object: "tap_1" });
    expect(worn.labels).not.toContain("Put it into something");
    worn.press("Move a part of it");
    const save = (): boolean | undefined => worn.menu.rows.flat().find(({ label }) => label === "Save")?.isDisabled;
    expect(save()).toBe(true);
    expect(worn.menu.values).toBe("? · Begins 0°, Ends 74°");
    worn.press("The gripper holds it");
    worn.press("Name it");
    for (const letter of "go on") {
      worn.press(letter === " " ? "space" : letter);
    }
    expect(worn.menu.body).toBe("go on_");
    worn.press("⌫");
    worn.press("Done");
    expect(worn.store.get("draft").action).toMatchObject({ name: "go_o", motion: { contact: "push", effect: "open" } });
    expect(save()).toBe(false);
    worn.press("Part that moves: handle");
    expect(worn.store.get("draft").action).toMatchObject({ motion: { joint: "spout", initiation: -1, termination: 1 } });
  });

  it("leave a name that is being written when the step is another", () => {
    const worn = new Worn();
    worn.store.learn({ step: "place", object: "flask_1" });
    worn.press("Rename");
    worn.press("a");
    worn.store.learn({ step: "overview" });
    expect(worn.menu.title).toBe("Your home");
  });

  it("change a shape by steps, finer ones in fine work", () => {
    const worn = new Worn();
    worn.store.learn({ step: "place", object: "flask_1" });
    worn.press("Diameter +");
    expect(worn.edits).toMatchObject([{ kind: "reshape_class", form: { diameter_m: 0.07 }, movable: true }]);
    worn.press("Speed 100 %");
    expect(worn.store.get("hand").speed).toBe(0.5);
    worn.store.receive({ type: "edit_answer", id: "other", outcome: { kind: "refused", reason: "" } });
    for (const speed of ["Speed 50 %", "Speed 25 %", "Speed 10 %"]) {
      worn.press(speed);
    }
    expect(worn.store.get("hand").speed).toBe(1);
  });

  it("offer to forget what is there, and to name only what is new", () => {
    const side = firstGrasp("side", flask, { radius: 0.03, height: 0.2 }, 0.1);
    const worn = new Worn({ ...teaching, classes: [bin, { ...flask, grasps: [side] }, tap] });
    worn.store.learn({ step: "grasps", object: "flask_1" });
    worn.press("side");
    expect(worn.labels).not.toContain("Name it");
    worn.press("Forget side");
    expect(worn.edits).toMatchObject([{ kind: "remove_grasp", class: "flask", name: "side" }]);
  });

  it("take nothing where nothing is taken, and say why", () => {
    const worn = new Worn({ ...teaching, closed: "another process has it" });
    expect(worn.menu.notice).toBe("another process has it");
    expect(worn.menu.list.every(({ isDisabled }) => isDisabled)).toBe(true);
    expect(worn.menu.rows.flat().find(({ label }) => label === "Undo")?.isDisabled).toBe(true);
    expect(new Worn(teaching, "view").menu.notice).toContain("opened to look");
    worn.press("Leave");
    expect(worn.hasLeft).toBe(true);
    expect(new Worn(null).menu.title).toContain("nothing to be taught");
  });

  it("place the robot first where they are asked to", () => {
    const worn = new Worn();
    worn.press("Place robot");
    expect(worn.menu.title).toBe("Where is the robot?");
    worn.press("Done");
    expect(worn.menu.title).toBe("Your home");
  });

  it.each(["overview", "class"] as const)("fit their sheet at step %s", (step) => fits(step));
  it.each(["place", "grasps", "actions"] as const)("fit their sheet at step %s of a thing", (step) => {
    for (const object of ["bin_1", "flask_1", "tap_1"]) {
      const worn = new Worn();
      worn.store.learn({ step, object });
      assertFits(worn.menu);
    }
  });
  it("fit their sheet while something is shown", () => {
    const worn = new Worn();
    worn.store.learn({ step: "grasps", object: "flask_1" });
    worn.press("Show a way to hold it");
    assertFits(worn.menu);
    worn.press("Name it");
    assertFits(worn.menu);
    worn.store.learn({ step: "actions", object: "tap_1" });
    worn.press("Move a part of it");
    assertFits(worn.menu);
  });
});

function fits(step: "overview" | "class"): void {
  const worn = new Worn();
  worn.store.learn({ step });
  assertFits(worn.menu);
}

/** All buttons are below the text, on the sheet, and none lies on another. */
function assertFits(menu: Menu): void {
  const all = placed(menu, 0, () => {});
  expect(all.length).toBeGreaterThan(0);
  for (const one of all) {
    expect(one.y >= TEXT_END_PX && one.y + one.height <= SHEET.height).toBe(true);
    const crosses = (other: Placed, along: "x" | "y", size: "width" | "height"): boolean =>
      other[along] < one[along] + one[size] && one[along] < other[along] + other[size];
    const under = all.filter((other) => crosses(other, "x", "width") && crosses(other, "y", "height"));
    expect(under).toEqual([one]);
  }
}
