// The menu that is shown now: the step's, with the tools of every step; the keyboard while a name is written; or how to
// place the robot.

import { closedBecause, type Desk } from "../teach/desk";
import { stepIndex, STEPS } from "../teach/lesson";
import { alignmentText, HEADSET, percentText, TEACH } from "../text";
import { keyboardMenu, type Writing } from "./keyboard";
import { EMPTY_MENU, type Menu, type MenuButton } from "./menu";
import { stepMenu } from "./steps";

/** Shares of the hand's way that things go: all of it, and ever finer. */
const SPEEDS: readonly number[] = [1, 0.5, 0.25, 0.1];

/** What a menu shows something of. */
const SHOWN = [
  "lesson",
  "draft",
  "teaching",
  "hand",
  "unanswered",
  "refusal",
  "connection",
  "role",
  "headset",
  "alignment",
] as const;

/** What only the headset itself can do. */
export interface Session {
  leave(): void;
  /** Whether drags move the world, to place the robot. */
  isAligning(): boolean;
  align(isAligning: boolean): void;
  hasRobot(): boolean;
}

export class Menus {
  /** Ends it. */
  readonly dispose: () => void;
  private writing: Writing | null = null;
  private writtenAt: unknown = null;

  constructor(
    private readonly desk: Desk,
    private readonly session: Session,
    private readonly changed: () => void,
  ) {
    this.dispose = desk.store.watch(SHOWN, changed);
  }

  menu(): Menu {
    const { store } = this.desk;
    // A name belongs to its step.
    if (this.writing !== null && this.writtenAt === store.get("lesson")) {
      return keyboardMenu(this.writing, (next) => this.write(next));
    }
    if (this.session.isAligning()) {
      return this.alignMenu();
    }
    const menu = store.get("teaching") === null ? { ...EMPTY_MENU, title: HEADSET.watchOnly } : this.taught();
    return { ...menu, notice: this.notice(), rows: [...menu.rows, this.tools(), this.exits()] };
  }

  private taught(): Menu {
    const lesson = this.desk.store.get("lesson");
    const at = stepIndex(lesson);
    const step = STEPS[at];
    const trail = step === undefined ? TEACH.title : HEADSET.trail(at + 1, STEPS.length, TEACH.steps[step]);
    const menu = stepMenu(this.desk, (writing) => this.write(writing));
    const isClosed = closedBecause(this.desk.store) !== "";
    const shut = (button: MenuButton): MenuButton => ({ ...button, isDisabled: true });
    return {
      ...menu,
      trail,
      list: isClosed ? menu.list.map(shut) : menu.list,
      rows: isClosed ? menu.rows.map((row) => row.map(shut)) : menu.rows,
    };
  }

  private write(next: Writing | null): void {
    this.writing = next;
    this.writtenAt = this.desk.store.get("lesson");
    this.changed();
  }

  private notice(): string {
    const { store } = this.desk;
    if (store.get("headset").lost) {
      return HEADSET.lost;
    }
    const refusal = store.get("refusal");
    if (refusal !== "") {
      return `${TEACH.refused}: ${refusal}`;
    }
    const closed = store.get("teaching") === null ? "" : closedBecause(store);
    return closed !== "" ? closed : store.get("unanswered") > 0 ? TEACH.saving : "";
  }

  private tools(): MenuButton[] {
    const { store } = this.desk;
    const hand = store.get("hand");
    return [
      { label: TEACH.move, isPressed: hand.mode === "move", run: () => store.handed({ mode: "move" }) },
      { label: TEACH.turn, isPressed: hand.mode === "turn", run: () => store.handed({ mode: "turn" }) },
      { label: HEADSET.snap, isPressed: hand.snap, run: () => store.handed({ snap: !hand.snap }) },
      this.speed(),
    ];
  }

  /** The next finer speed; after the finest, the whole way again. */
  private speed(): MenuButton {
    const { store } = this.desk;
    const { speed } = store.get("hand");
    const finer = SPEEDS.find((other) => other < speed - 1e-9) ?? 1;
    return { label: HEADSET.speed(percentText(speed)), run: () => store.handed({ speed: finer }) };
  }

  private exits(): MenuButton[] {
    const { store, edits } = this.desk;
    const teaching = store.get("teaching");
    const isOpen = store.get("connection").kind === "open" && closedBecause(store) === "";
    const busy = store.get("unanswered") > 0 || !isOpen;
    const cannot = (what: string | null | undefined): boolean => busy || (what ?? null) === null;
    return [
      { label: TEACH.undo, isDisabled: cannot(teaching?.undo), run: () => void edits.ask({ kind: "undo" }) },
      { label: TEACH.redo, isDisabled: cannot(teaching?.redo), run: () => void edits.ask({ kind: "redo" }) },
      { label: HEADSET.align, run: () => this.session.align(true) },
      { label: HEADSET.leave, run: () => this.session.leave() },
    ];
  }

  private alignMenu(): Menu {
    return {
      ...EMPTY_MENU,
      trail: alignmentText(this.desk.store.get("alignment")),
      title: HEADSET.alignTitle,
      body: this.session.hasRobot() ? HEADSET.alignBody : HEADSET.originBody,
      notice: this.notice(),
      rows: [
        [this.speed()],
        [{ label: HEADSET.done, isPrimary: true, run: () => this.session.align(false) }],
      ],
    };
  }
}
