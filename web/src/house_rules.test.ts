// Rules that the compiler does not check.

import { describe, expect, it } from "vitest";

const sources = import.meta.glob<string>("./**/*.ts", { query: "?raw", import: "default", eager: true });
const own = Object.entries(sources).filter(
  ([path]) => !path.endsWith(".test.ts") && path !== "./protocol.ts",
);

const FORBIDDEN: readonly [string, RegExp][] = [
  ["any", /(:|\bas|<|\|)\s*any\b/],
  ["a promise to the compiler that something is there", /[\w)\]]!(\.|;|,|\)|\[)/],
  ["markup from text", /innerHTML|outerHTML|insertAdjacentHTML/],
  ["a silenced compiler", /@ts-(ignore|expect-error|nocheck)/],
];

describe("the sources", () => {
  it("are found", () => {
    expect(own.length).toBeGreaterThan(20);
  });

  it.each(FORBIDDEN)("do without %s", (_what, pattern) => {
    const offenders = own.filter(([, text]) => pattern.test(text)).map(([path]) => path);
    expect(offenders).toEqual([]);
  });
});
