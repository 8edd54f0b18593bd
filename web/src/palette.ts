// Colours that people with any colour vision can tell apart: the eight of Okabe and Ito ("Color
// Universal Design", 2008), without black, in an order that keeps neighbours far apart. Colour is
// never the only carrier: regions also have numbers, states also have icons and words.

export const REGION_COLOURS: readonly string[] = [
  "#0072b2", // blue
  "#e69f00", // orange
  "#009e73", // bluish green
  "#cc79a7", // reddish purple
  "#56b4e9", // sky blue
  "#d55e00", // vermilion
  "#f0e442", // yellow
];

const FALLBACK = "#0072b2";

/** The colour of a region; colours come round again when there are more regions. */
export function regionColour(index: number): string {
  return REGION_COLOURS[Math.abs(Math.trunc(index)) % REGION_COLOURS.length] ?? FALLBACK;
}

/** Black or white, whichever is easier to read on the colour (by its relative luminance). */
export function inkOn(colour: string): string {
  const channel = (from: number): number => {
    const value = Number.parseInt(colour.slice(from, from + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  const luminance = 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
  // Equal contrast to black and white lies at about 0.18.
  return luminance > 0.18 ? "#000000" : "#ffffff";
}
