import { describe, expect, it } from "vitest";

import { decode } from "./decode";

describe("a text frame", () => {
  it("becomes a message by its type", () => {
    const text = '{"type":"done","achieved":true,"summary":"all well"}';
    expect(decode(text)).toEqual({ type: "done", achieved: true, summary: "all well" });
  });

  it.each([
    "",
    "{",
    "null",
    "3",
    '"hello"',
    "[]",
    "{}",
    '{"type":3}',
    '{"type":"explode"}',
    '{"type":"constructor"}',
    '{"type":"__proto__"}',
  ])("that is something else says so: %s", (text) => {
    expect(typeof decode(text)).toBe("string");
  });
});
