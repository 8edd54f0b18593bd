// Where the parts of a menu are on its sheet, in pixels from its upper left corner.

import { HEADSET } from "../text";
import type { Menu, MenuButton } from "./menu";

export const SHEET = { width: 1024, height: 1280 } as const;
/** The strip by which the whole sheet is taken. */
export const HEADER_PX = 84;
const MARGIN = 36;
const GAP = 14;
const BUTTON_PX = 76;
const COLUMNS = 3;
/** Rows of the list on one page. */
const LIST_ROWS = 3;
/** Where buttons begin: what comes above is text. */
export const TEXT_END_PX = 470;

export interface Placed {
  readonly button: MenuButton;
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** How many pages the list has: one at least. */
export function pagesOf(menu: Menu): number {
  return Math.max(1, Math.ceil(menu.list.length / perPage(menu)));
}

function perPage(menu: Menu): number {
  const all = COLUMNS * LIST_ROWS;
  return menu.list.length <= all ? all : all - 2;
}

/** The buttons in their places; a list that is too long ends in two buttons that turn its pages. */
export function placed(menu: Menu, page: number, turnTo: (page: number) => void): Placed[] {
  const pages = pagesOf(menu);
  const at = Math.min(Math.max(page, 0), pages - 1);
  const shown: MenuButton[] = menu.list.slice(at * perPage(menu), (at + 1) * perPage(menu));
  if (pages > 1) {
    shown.push(
      { label: HEADSET.earlier, run: () => turnTo(at - 1), isDisabled: at === 0 },
      { label: HEADSET.later, run: () => turnTo(at + 1), isDisabled: at === pages - 1 },
    );
  }
  const pitch = BUTTON_PX + GAP;
  // The list hangs below the text, the rows stand on the sheet's foot: what is always there is always at its place.
  const list = shown.map((button, index) =>
    cell(button, COLUMNS, index % COLUMNS, TEXT_END_PX + Math.floor(index / COLUMNS) * pitch),
  );
  const rows = menu.rows.filter((row) => row.length > 0);
  const top = SHEET.height - MARGIN + GAP - rows.length * pitch;
  return [
    ...list,
    ...rows.flatMap((row, index) => row.map((button, column) => cell(button, row.length, column, top + index * pitch))),
  ];
}

function cell(button: MenuButton, columns: number, column: number, y: number): Placed {
  const width = (SHEET.width - 2 * MARGIN - (columns - 1) * GAP) / columns;
  return { button, x: MARGIN + column * (width + GAP), y, width, height: BUTTON_PX };
}

/** The button at a point. */
export function buttonAt(all: readonly Placed[], x: number, y: number): Placed | null {
  return all.find((one) => one.x <= x && x <= one.x + one.width && one.y <= y && y <= one.y + one.height) ?? null;
}

/** Text in lines no wider than `width`, as `measure` measures them; the last ends in an ellipsis if there is more. */
export function wrapped(text: string, width: number, linesMax: number, measure: (line: string) => number): string[] {
  const lines: string[] = [];
  let line = "";
  for (const word of text.split(" ")) {
    const longer = line === "" ? word : `${line} ${word}`;
    if (line !== "" && measure(longer) > width) {
      lines.push(line);
      line = word;
    } else {
      line = longer;
    }
  }
  lines.push(line);
  if (lines.length <= linesMax) {
    return lines;
  }
  const kept = lines.slice(0, linesMax);
  return [...kept.slice(0, -1), `${kept.at(-1) ?? ""} …`];
}
