// Names of objects and numbers of regions, as HTML above the canvas: crisp, themed, selectable.

import { type Object3D, type PerspectiveCamera, Vector3 } from "three";

import { element } from "../dom";
import { inkOn, regionColour } from "../palette";
import type { Aosm, Teaching } from "../protocol";
import { words } from "../text";
import { centreOf } from "./regions_layer";

/** How far above an object's origin its name floats. */
const OBJECT_LIFT_M = 0.22;
const GAP_PX = 3;

interface Label {
  readonly node: HTMLElement;
  /** In the wire's world. */
  readonly anchor: Vector3;
  readonly kind: "object" | "region";
  width: number;
  height: number;
  left: number;
  top: number;
  distance: number;
  shown: boolean;
}

export class Labels {
  readonly root = element("div", { class: "labels", "aria-hidden": "true" });
  private labels: Label[] = [];
  private readonly point = new Vector3();

  /** Shows names, with a swatch for what has a colour of its own. */
  show(aosm: Aosm | null, teaching: Teaching | null): void {
    this.root.replaceChildren();
    this.labels = [];
    for (const object of aosm?.objects ?? []) {
      const node = element("div", { class: "label object" }, element("b", {}, words(object.name)));
      const taught = teaching?.objects.find((other) => other.name === object.name);
      if (taught !== undefined) {
        const swatch = element("i", { class: "swatch" });
        swatch.style.backgroundColor = regionColour(taught.colour_index);
        node.prepend(swatch, " ");
      }
      if (object.state !== "") {
        node.append(" ", element("span", {}, object.state));
      }
      const [x, y, z] = object.pose.position;
      this.add("object", node, new Vector3(x, y, z + OBJECT_LIFT_M));
    }
    aosm?.regions.forEach((region, index) => {
      const centre = centreOf(region);
      if (centre !== null) {
        const node = element("div", { class: "label number" }, String(index + 1));
        const colour = regionColour(region.colour_index);
        node.style.backgroundColor = colour;
        node.style.color = inkOn(colour);
        this.add("region", node, new Vector3(centre[0], centre[1], 0.05));
      }
    });
    for (const label of this.labels) {
      label.width = label.node.offsetWidth;
      label.height = label.node.offsetHeight;
    }
  }

  /** Puts the labels where their anchors appear; where two would overlap, the nearer is shown. */
  update(
    world: Object3D,
    camera: PerspectiveCamera,
    width: number,
    height: number,
    visible: Readonly<Record<Label["kind"], boolean>>,
  ): void {
    for (const label of this.labels) {
      this.point.copy(label.anchor).applyMatrix4(world.matrixWorld);
      label.distance = this.point.distanceTo(camera.position);
      this.point.project(camera);
      label.left = (this.point.x * 0.5 + 0.5) * width - label.width / 2;
      label.top = (0.5 - this.point.y * 0.5) * height - label.height / 2;
      const inside = Math.abs(this.point.x) < 1.1 && Math.abs(this.point.y) < 1.1 && this.point.z < 1;
      label.shown = visible[label.kind] && inside;
    }
    this.labels.sort((a, b) => a.distance - b.distance);
    this.labels.forEach((label, index) => {
      for (let other = 0; label.shown && other < index; other++) {
        const nearer = this.labels[other];
        label.shown = nearer === undefined || !nearer.shown || !overlap(label, nearer);
      }
      const { style } = label.node;
      style.visibility = label.shown ? "visible" : "hidden";
      if (label.shown) {
        style.transform = `translate(${Math.round(label.left)}px, ${Math.round(label.top)}px)`;
      }
    });
  }

  private add(kind: Label["kind"], node: HTMLElement, anchor: Vector3): void {
    this.root.append(node);
    const nowhere = { width: 0, height: 0, left: 0, top: 0, distance: 0, shown: false };
    this.labels.push({ node, anchor, kind, ...nowhere });
  }
}

function overlap(a: Label, b: Label): boolean {
  return (
    a.left < b.left + b.width + GAP_PX &&
    b.left < a.left + a.width + GAP_PX &&
    a.top < b.top + b.height + GAP_PX &&
    b.top < a.top + a.height + GAP_PX
  );
}
