// A menu in the world: what a step says and which buttons it has. What the buttons do is done at the desk, as on the
// page; a menu has no state of its own.

export interface MenuButton {
  readonly label: string;
  readonly run: () => void;
  readonly isDisabled?: boolean;
  /** Whether a switch is on; nothing for what is no switch. */
  readonly isPressed?: boolean;
  readonly isPrimary?: boolean;
  /** Colour of what it stands for. */
  readonly swatch?: string;
}

export interface Menu {
  /** Where in the course of teaching this is: "2 of 4: Where". */
  readonly trail: string;
  readonly title: string;
  /** What is being told of the thing, and what comes next. */
  readonly body: string;
  /** What it is now, in numbers. */
  readonly values: string;
  /** What went wrong, or is waited for. */
  readonly notice: string;
  /** Any number of buttons, shown a page at a time. */
  readonly list: readonly MenuButton[];
  /** Buttons that are always there, row by row. */
  readonly rows: readonly (readonly MenuButton[])[];
}

export const EMPTY_MENU: Menu = { trail: "", title: "", body: "", values: "", notice: "", list: [], rows: [] };
