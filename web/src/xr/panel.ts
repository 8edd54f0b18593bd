// A menu's sheet in the world: drawn to a canvas, pointed at with a ray, taken away by its head.

import { CanvasTexture, Group, LinearFilter, Mesh, MeshBasicMaterial, PlaneGeometry, type Raycaster, SRGBColorSpace } from "three";

import { element } from "../dom";
import type { Theme } from "../view/theme";
import { EMPTY_MENU, type Menu } from "./menu";
import { buttonAt, HEADER_PX, type Placed, placed, SHEET, TEXT_END_PX, wrapped } from "./menu_layout";

/** Width in the world, metres: at arm's length and a half, letters of 1.2°. */
const WIDTH_M = 0.64;
export const HEIGHT_M = (WIDTH_M * SHEET.height) / SHEET.width;
/** Pixels of the texture for one of the layout: as fine as headsets show at this distance, and no finer. */
const FINENESS = 0.75;
const PX_TO_M = WIDTH_M / SHEET.width;
const MARGIN_PX = 36;
const LINE_PX = 40;
const FONT = "system-ui, 'Noto Sans', 'DejaVu Sans', sans-serif";

/** What a ray points at on a panel. */
export type OnPanel =
  | { readonly part: "button"; readonly button: Placed; readonly distance: number }
  | { readonly part: "head" | "sheet"; readonly distance: number };

export class Panel {
  readonly root = new Group();
  private readonly canvas = element("canvas", {
    width: String(FINENESS * SHEET.width),
    height: String(FINENESS * SHEET.height),
  });
  private readonly pen = this.canvas.getContext("2d");
  private readonly texture = new CanvasTexture(this.canvas);
  private readonly sheet: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private menu: Menu = EMPTY_MENU;
  private all: Placed[] = [];
  private page = 0;
  private shownTitle = "";
  private hovered = "";

  constructor(private readonly colours: () => Pick<Theme, "background" | "accent">) {
    this.pen?.scale(FINENESS, FINENESS);
    this.texture.colorSpace = SRGBColorSpace;
    this.texture.generateMipmaps = false;
    this.texture.minFilter = LinearFilter;
    // Fog would swallow what is written, and tone mapping its colours.
    const material = new MeshBasicMaterial({ map: this.texture, fog: false, toneMapped: false });
    this.sheet = new Mesh(new PlaneGeometry(WIDTH_M, HEIGHT_M), material);
    this.sheet.renderOrder = 3;
    this.root.add(this.sheet);
  }

  get title(): string {
    return this.menu.title;
  }

  get shown(): Menu {
    return this.menu;
  }

  get buttons(): readonly Placed[] {
    return this.all;
  }

  /** Where the middle of a button is, in the panel's frame, metres. */
  pointOf({ x, y, width, height }: Placed): [number, number, number] {
    return [(x + width / 2) * PX_TO_M - WIDTH_M / 2, HEIGHT_M / 2 - (y + height / 2) * PX_TO_M, 0];
  }

  /** Where the middle of the head is, in the panel's frame, metres. */
  get headPoint(): [number, number, number] {
    return [0, HEIGHT_M / 2 - (HEADER_PX / 2) * PX_TO_M, 0];
  }

  show(menu: Menu): void {
    this.menu = menu;
    if (menu.title !== this.shownTitle) {
      this.shownTitle = menu.title;
      this.page = 0;
    }
    this.arrange();
  }

  /** What a ray points at, if it points at this. */
  at(ray: Raycaster): OnPanel | null {
    const [hit] = ray.intersectObject(this.sheet, false);
    if (hit?.uv === undefined) {
      return null;
    }
    const [x, y] = [hit.uv.x * SHEET.width, (1 - hit.uv.y) * SHEET.height];
    const button = buttonAt(this.all, x, y);
    if (button !== null) {
      return { part: "button", button, distance: hit.distance };
    }
    return { part: y < HEADER_PX ? "head" : "sheet", distance: hit.distance };
  }

  /** Marks what is pointed at. */
  hover(at: OnPanel | null): void {
    const name = at?.part === "button" ? at.button.button.label : (at?.part ?? "");
    if (name !== this.hovered) {
      this.hovered = name;
      this.draw();
    }
  }

  private arrange(): void {
    this.all = placed(this.menu, this.page, (page) => {
      this.page = page;
      this.arrange();
    });
    this.draw();
  }

  private draw(): void {
    const { pen, menu } = this;
    if (pen === null) {
      return;
    }
    const { background, accent } = this.colours();
    const isDark = (background >> 8) % 256 < 128;
    const ink = isDark ? "#f2f4f6" : "#12181e";
    const dim = isDark ? "#aeb8c1" : "#4a5863";
    const look = { ink, face: isDark ? "#2a323a" : "#dfe5ea", accent: css(accent), accentInk: isDark ? "#000000" : "#ffffff" };
    pen.fillStyle = isDark ? "#1c2228" : "#ffffff";
    pen.fillRect(0, 0, SHEET.width, SHEET.height);
    pen.fillStyle = this.hovered === "head" ? look.accent : look.face;
    pen.fillRect(0, 0, SHEET.width, HEADER_PX);
    pen.textBaseline = "middle";
    const width = SHEET.width - 2 * MARGIN_PX;
    const measure = (line: string): number => pen.measureText(line).width;
    this.line(menu.trail, MARGIN_PX, HEADER_PX / 2, `600 32px ${FONT}`, this.hovered === "head" ? look.accentInk : dim);
    let y = HEADER_PX + 48;
    pen.font = `700 46px ${FONT}`;
    for (const line of wrapped(menu.title, width, 2, measure)) {
      this.line(line, MARGIN_PX, y, pen.font, ink);
      y += 54;
    }
    pen.font = `400 32px ${FONT}`;
    for (const line of wrapped(menu.body, width, 4, measure)) {
      this.line(line, MARGIN_PX, y, pen.font, ink);
      y += LINE_PX;
    }
    pen.font = `600 32px ${FONT}`;
    const values = wrapped(menu.values, width, 2, measure);
    const notice = wrapped(menu.notice, width, 2, measure);
    const below = menu.notice === "" ? values : notice;
    below.forEach((line, index) => {
      const at = TEXT_END_PX - 28 - (below.length - 1 - index) * LINE_PX;
      this.line(line, MARGIN_PX, at, pen.font, menu.notice === "" ? dim : look.accent);
    });
    for (const one of this.all) {
      this.drawButton(one, look);
    }
    // An edge, so that the sheet does not run into what is behind it.
    pen.lineWidth = 6;
    pen.strokeStyle = dim;
    pen.strokeRect(3, 3, SHEET.width - 6, SHEET.height - 6);
    this.texture.needsUpdate = true;
  }

  private drawButton(one: Placed, look: Record<"ink" | "face" | "accent" | "accentInk", string>): void {
    const { pen } = this;
    if (pen === null) {
      return;
    }
    const { button, x, y, width, height } = one;
    const isFull = button.isPrimary === true || button.isPressed === true;
    pen.globalAlpha = button.isDisabled === true ? 0.4 : 1;
    pen.beginPath();
    pen.roundRect(x, y, width, height, 12);
    pen.fillStyle = isFull ? look.accent : look.face;
    pen.fill();
    if (this.hovered === button.label) {
      pen.lineWidth = 6;
      pen.strokeStyle = look.ink;
      pen.stroke();
    }
    let left = x + 16;
    if (button.swatch !== undefined) {
      pen.fillStyle = button.swatch;
      pen.fillRect(left, y + height / 2 - 15, 30, 30);
      left += 44;
    }
    // A switch shows by more than its colour whether it is on.
    const label = button.isPressed === true ? `✓ ${button.label}` : button.label;
    const room = x + width - 12 - left;
    let size = 32;
    pen.font = `500 ${size}px ${FONT}`;
    while (size > 20 && pen.measureText(label).width > room) {
      size -= 2;
      pen.font = `500 ${size}px ${FONT}`;
    }
    const inset = button.swatch === undefined ? Math.max(0, (room - pen.measureText(label).width) / 2) : 0;
    pen.fillStyle = isFull ? look.accentInk : look.ink;
    pen.fillText(label, left + inset, y + height / 2 + 2, room);
    pen.globalAlpha = 1;
  }

  private line(text: string, x: number, y: number, font: string, colour: string): void {
    if (this.pen !== null) {
      this.pen.font = font;
      this.pen.fillStyle = colour;
      this.pen.fillText(text, x, y);
    }
  }

  dispose(): void {
    this.texture.dispose();
    this.sheet.geometry.dispose();
    this.sheet.material.dispose();
  }
}

function css(colour: number): string {
  return `#${colour.toString(16).padStart(6, "0")}`;
}
