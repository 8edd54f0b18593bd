import { describe, expect, it } from "vitest";

import { inkOn, REGION_COLOURS, regionColour } from "./palette";

/** Contrast ratio of WCAG 2, from 1 to 21. */
function contrast(a: string, b: string): number {
  const luminance = (colour: string): number => {
    const [r = 0, g = 0, blue = 0] = [1, 3, 5].map((from) => {
      const value = Number.parseInt(colour.slice(from, from + 2), 16) / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * blue;
  };
  const [low = 0, high = 0] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

describe("colours of regions", () => {
  it("are all different and come round again", () => {
    expect(new Set(REGION_COLOURS).size).toBe(REGION_COLOURS.length);
    expect(regionColour(REGION_COLOURS.length)).toBe(regionColour(0));
    expect(REGION_COLOURS).toContain(regionColour(-1));
    expect(REGION_COLOURS).toContain(regionColour(3.7));
  });

  it("carry numbers that can be read", () => {
    for (const colour of REGION_COLOURS) {
      expect(contrast(colour, inkOn(colour)), colour).toBeGreaterThan(4.5);
    }
  });
});
