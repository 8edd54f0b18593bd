// Colours of the scene for a light and a dark page. Those of regions and bodies are not here: the
// first come from the palette, the second from the wire.

export interface Theme {
  readonly background: number;
  readonly gridLine: number;
  readonly gridLineStrong: number;
  readonly edge: number;
  readonly edgeOpacity: number;
  readonly shadowOpacity: number;
  /** How bright the lights are, 1 being day. */
  readonly light: number;
  readonly sky: number;
  readonly ground: number;
  readonly accent: number;
  /** Occupancy cells as red, green, blue and opacity, each 0 to 255. */
  readonly free: Rgba;
  readonly occupied: Rgba;
  readonly unknown: Rgba;
}

export type Rgba = readonly [number, number, number, number];

const LIGHT: Theme = {
  background: 0xeceff1,
  gridLine: 0xd5dade,
  gridLineStrong: 0xbcc4ca,
  edge: 0x24303a,
  edgeOpacity: 0.22,
  shadowOpacity: 0.22,
  light: 1,
  sky: 0xffffff,
  ground: 0xcfc8bd,
  accent: 0x0072b2,
  free: [255, 255, 255, 40],
  occupied: [28, 38, 48, 235],
  unknown: [84, 100, 116, 80],
};

const DARK: Theme = {
  background: 0x14181c,
  gridLine: 0x232a30,
  gridLineStrong: 0x323b43,
  edge: 0x000000,
  edgeOpacity: 0.35,
  shadowOpacity: 0.5,
  light: 0.68,
  sky: 0xdfe8f0,
  ground: 0x4c4a48,
  accent: 0x56b4e9,
  free: [255, 255, 255, 22],
  occupied: [6, 9, 12, 235],
  unknown: [8, 12, 16, 150],
};

const query = window.matchMedia("(prefers-color-scheme: dark)");

export function currentTheme(): Theme {
  return query.matches ? DARK : LIGHT;
}

export function onThemeChange(listener: () => void): void {
  query.addEventListener("change", listener);
}
