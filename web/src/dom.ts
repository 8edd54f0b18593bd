// Building elements. Text only ever becomes text, so nothing that is received can become markup.

type Attributes = Readonly<Record<string, string | boolean>>;
type Child = Node | string;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: readonly Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  setAttributes(made, attributes);
  made.append(...children);
  return made;
}

export function setAttributes(target: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false) {
      target.removeAttribute(name);
    } else {
      target.setAttribute(name, value === true ? "" : value);
    }
  }
}

/** The element that the page's HTML promises. */
export function required(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (found === null) {
    throw new Error(`the page has no element with id "${id}"`);
  }
  return found;
}

/** Whether a key is being typed into something, rather than pressed for the page. */
export function isTyping(event: KeyboardEvent): boolean {
  const { target } = event;
  return (
    target instanceof HTMLInputElement ||
    target instanceof HTMLSelectElement ||
    target instanceof HTMLTextAreaElement
  );
}

const SVG = "http://www.w3.org/2000/svg";

/** An element of a drawing. */
export function drawing<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: readonly Child[]
): SVGElementTagNameMap[K] {
  const made = document.createElementNS(SVG, tag);
  setAttributes(made, attributes);
  made.append(...children);
  return made;
}

/** Strokes on a 24 by 24 sheet. */
const ICONS = {
  pending: "M12 5a7 7 0 1 0 .01 0",
  running: "M8 5.5v13l10.5-6.5z",
  done: "M5 12.5l4.5 4.5L19 7.5",
  failed: "M6.5 6.5l11 11M17.5 6.5l-11 11",
  skipped: "M5 7l6 5-6 5M13 7l6 5-6 5",
  pause: "M8.5 6v12M15.5 6v12",
  stop: "M7 7h10v10H7z",
  follow: "M12 8.5a3.5 3.5 0 1 0 .01 0M12 3v3M12 18v3M3 12h3M18 12h3",
  map: "M4 6.5l5-2 6 2 5-2v13l-5 2-6-2-5 2zM9 4.5v13M15 6.5v13",
  regions: "M12 21s6.5-6 6.5-11a6.5 6.5 0 0 0-13 0c0 5 6.5 11 6.5 11zM12 8a2.2 2.2 0 1 0 .01 0",
  labels: "M4 5h9l7 7-8 8-8-8zM8 9h.01",
  info: "M12 11.5v4.5M12 8v.01M12 3a9 9 0 1 0 .01 0",
  warning: "M12 8v5M12 16.5v.01M12 3.5L2.5 20h19z",
  error: "M12 7v6M12 16.5v.01M12 3a9 9 0 1 0 .01 0",
  forward: "M12 20V5M6 11l6-6 6 6",
  back: "M12 4v15M6 13l6 6 6-6",
  left: "M20 12H5M11 6l-6 6 6 6",
  right: "M4 12h15M13 6l6 6-6 6",
  turnLeft: "M5 13a7 7 0 1 0 7-7M14.5 2.5L11 6l3.5 3.5",
  turnRight: "M19 13a7 7 0 1 1-7-7M9.5 2.5L13 6 9.5 9.5",
  navigate: "M12 4l7 16-7-4-7 4z",
  undo: "M9 14L4 9l5-5M4 9h10a6 6 0 0 1 0 12h-3",
  redo: "M15 14l5-5-5-5M20 9H10a6 6 0 0 0 0 12h3",
  add: "M12 5v14M5 12h14",
  manipulate: "M7 20h10M12 20v-6M12 14l-5-5 3-5M7 9h6M13 9l3-2M13 9l3 2",
} as const;

export type IconName = keyof typeof ICONS;

export function icon(name: IconName): SVGSVGElement {
  return drawing(
    "svg",
    { viewBox: "0 0 24 24", "aria-hidden": "true", class: `icon icon-${name}` },
    drawing("path", { d: ICONS[name] }),
  );
}
