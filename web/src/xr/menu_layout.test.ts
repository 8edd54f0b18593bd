import { describe, expect, it } from "vitest";

import { EMPTY_MENU, type MenuButton } from "./menu";
import { buttonAt, pagesOf, placed, SHEET, wrapped } from "./menu_layout";

const buttons = (n: number): MenuButton[] => Array.from({ length: n }, (_, index) => ({ label: `b${index}`, run: () => {} }));

describe("a menu's sheet", () => {
  it.each([0, 1, 9, 10, 40])("holds every one of %i things, page by page, and never on top of another", (n) => {
    const menu = { ...EMPTY_MENU, list: buttons(n), rows: [buttons(2), buttons(5), buttons(3), buttons(4)] };
    const seen = new Set<string>();
    for (let page = 0; page < pagesOf(menu); page++) {
      const all = placed(menu, page, () => {});
      all.forEach(({ button, x, y, width, height }, index) => {
        seen.add(button.label);
        expect(x >= 0 && y >= 0 && x + width <= SHEET.width && y + height <= SHEET.height).toBe(true);
        expect(buttonAt(all, x + width / 2, y + height / 2)).toBe(all[index]);
      });
    }
    for (const { label } of menu.list) {
      expect(seen).toContain(label);
    }
  });

  it("turns pages within what there is", () => {
    let page = 0;
    const menu = { ...EMPTY_MENU, list: buttons(20) };
    const press = (label: string): void => {
      const found = placed(menu, page, (to) => (page = to)).find(({ button }) => button.label === label);
      if (found?.button.isDisabled === false) {
        found.button.run();
      }
    };
    press("‹ Earlier");
    expect(page).toBe(0);
    for (let n = 0; n < 9; n++) {
      press("More ›");
    }
    expect(page).toBe(pagesOf(menu) - 1);
    // A list that has become shorter meanwhile shows its last page.
    expect(placed({ ...menu, list: buttons(2) }, page, () => {}).length).toBe(2);
  });

  it("finds no button between two", () => {
    const all = placed({ ...EMPTY_MENU, rows: [buttons(2)] }, 0, () => {});
    expect(buttonAt(all, SHEET.width / 2, all[0]?.y ?? 0)).toBeNull();
  });
});

describe("text", () => {
  const measure = (line: string): number => line.length;

  it("breaks between words", () => {
    expect(wrapped("one two three four", 9, 9, measure)).toEqual(["one two", "three", "four"]);
    expect(wrapped("unbreakable", 3, 9, measure)).toEqual(["unbreakable"]);
    expect(wrapped("", 3, 9, measure)).toEqual([""]);
  });

  it("says that there is more", () => {
    expect(wrapped("one two three four", 9, 2, measure)).toEqual(["one two", "three …"]);
  });
});
