// One time of wearing a headset: the scene about the person, the panel, and what the hands do.

import { Group, PerspectiveCamera, Vector3 } from "three";

import { composed, place, poseOf } from "../frames";
import type { Pose } from "../protocol";
import type { Desk } from "../teach/desk";
import { currentTheme } from "../view/theme";
import type { Eyes, View } from "../view/view";
import { alongRay, carriedDrag, type Drag, jointDrag, thingDrag, worldDrag } from "./drags";
import { lookedAtFrom } from "./gaze";
import { firstPlace, mapPose, poseOfMapFromXr, recentred, standingAt } from "./map_from_xr";
import { Menus } from "./menus";
import type { Mode } from "./offer";
import { Panel } from "./panel";
import { besidePanel, isOutOfReach } from "./panel_place";
import { Pointing, type Target } from "./pointing";
import type { Seen } from "./probe";
import { type Press, type Ray, type RayEvents, rays } from "./rays";
import { standIn } from "./stand_in";

/** While something is dragged, its numbers are drawn anew so often: a sheet is costly. */
const MENU_SECS = 0.2;

interface Holding {
  readonly drag: Drag;
  readonly press: Press;
  readonly distance: number;
  /** Whether the other hand can help. */
  readonly isThing: boolean;
}

export class HeadsetSession implements Eyes, RayEvents {
  readonly camera = new PerspectiveCamera(70, 1, 0.02, 100);
  readonly seesRoom: boolean;
  /** XR's origin, below the wire's world. */
  private readonly origin = new Group();
  private readonly panel = new Panel(currentTheme);
  private readonly menus: Menus;
  private readonly pointing: Pointing;
  private readonly robot = standIn(currentTheme().accent);
  private readonly rays: readonly Ray[];
  private readonly holding = new Map<Ray, Holding>();
  private readonly unwatch: () => void;
  private head: Pose | null = null;
  private isAligning: boolean;
  private isMenuOld = true;
  private sinceMenuSecs = 0;
  private hasPanel = false;
  private readonly point = new Vector3();

  constructor(
    private readonly desk: Desk,
    private readonly view: View,
    session: XRSession,
    private readonly mode: Mode,
  ) {
    this.seesRoom = mode === "immersive-ar";
    // In the room, nothing is where it is before the robot is.
    this.isAligning = this.seesRoom;
    const { store } = desk;
    this.menus = new Menus(
      desk,
      {
        leave: () => void session.end(),
        isAligning: () => this.isAligning,
        align: (isAligning) => this.align(isAligning),
        hasRobot: () => store.get("scenes").has("robot"),
      },
      () => {
        this.isMenuOld = true;
      },
    );
    this.pointing = new Pointing(store, view, this.panel);
    this.origin.add(this.camera, this.panel.root);
    this.panel.root.visible = false;
    view.world.add(this.origin, this.robot);
    this.rays = rays(view.renderer.xr, this.origin, { colour: currentTheme().accent, seesRoom: this.seesRoom }, this);
    store.aligned(standingAt(firstPlace(store.get("live")?.base ?? null, store.get("map"))), "placed");
    this.unwatch = store.watch(["alignment"], () => place(this.origin, poseOfMapFromXr(store.get("alignment").mapFromXr)));
  }

  /** Follows the headset when it moves its own origin. */
  follow(space: XRReferenceSpace): void {
    const { store } = this.desk;
    space.addEventListener("reset", ({ transform }) => {
      const { mapFromXr } = store.get("alignment");
      // Without a transform the headset does not know by how much.
      if (transform === undefined || transform === null) {
        store.aligned(mapFromXr, "lost");
        this.align(this.seesRoom);
      } else {
        store.aligned(recentred(mapFromXr, poseFrom(transform)), "recentred");
      }
    });
  }

  dispose(): void {
    // What is still held is let go where it is.
    for (const { drag } of this.holding.values()) {
      drag.end();
    }
    this.holding.clear();
    for (const ray of this.rays) {
      ray.dispose();
    }
    this.origin.removeFromParent();
    this.robot.removeFromParent();
    this.panel.dispose();
    this.menus.dispose();
    this.unwatch();
  }

  lookedAt(): [number, number] {
    if (this.head === null) {
      const [x, y] = this.desk.store.get("alignment").mapFromXr.position;
      return [x, y];
    }
    const head = mapPose(this.desk.store.get("alignment").mapFromXr, this.head);
    const [x, y, z] = composed(head, { position: [0, 0, -1], orientation_xyzw: [0, 0, 0, 1] }).position;
    return lookedAtFrom(head.position, [x - head.position[0], y - head.position[1], z - head.position[2]]);
  }

  update(frame: XRFrame, dtSecs: number): void {
    this.lookFor(frame);
    this.sinceMenuSecs += dtSecs;
    if (this.isMenuOld && (this.holding.size === 0 || this.sinceMenuSecs > MENU_SECS)) {
      this.isMenuOld = false;
      this.sinceMenuSecs = 0;
      this.panel.show(this.menus.menu());
    }
    this.robot.visible = this.isAligning && !this.desk.store.get("scenes").has("robot");
    let onPanel: Target | null = null;
    for (const ray of this.rays) {
      if (!ray.isTracked) {
        continue;
      }
      ray.aim();
      const held = this.holding.get(ray);
      if (held !== undefined) {
        held.drag.move(ray.xrFromRay(), held.isThing ? this.helper(ray) : null);
        ray.reach(held.distance, true);
        continue;
      }
      const target = this.target(ray);
      ray.reach(target.distance, target.kind === "thing" || target.kind === "object");
      onPanel = target.kind === "panel" ? target : onPanel;
    }
    this.panel.hover(onPanel?.kind === "panel" ? onPanel.at : null);
  }

  /** Where the head is; the panel comes to where it can be read. */
  private lookFor(frame: XRFrame): void {
    const space = this.view.renderer.xr.getReferenceSpace();
    const pose = space === null ? undefined : frame.getViewerPose(space);
    const isLost = pose === undefined || pose === null;
    if (isLost !== this.desk.store.get("headset").lost) {
      this.desk.store.worn({ lost: isLost });
    }
    if (isLost) {
      return;
    }
    this.head = poseFrom(pose.transform);
    const isHeld = [...this.holding.values()].some(({ isThing }) => !isThing);
    if (!this.hasPanel || (!isHeld && isOutOfReach(this.head, poseOf(this.panel.root)))) {
      this.hasPanel = true;
      place(this.panel.root, besidePanel(this.head));
      this.panel.root.visible = true;
    }
  }

  private target(ray: Ray): Target {
    const target = this.pointing.target(ray.caster);
    // Who places the robot moves the world, whatever of it is taken.
    const isTaken = target.kind === "thing" || target.kind === "object";
    return this.isAligning && isTaken ? { kind: "world", distance: target.distance } : target;
  }

  /** Where another hand is that holds nothing of its own, in XR. */
  private helper(ray: Ray): [number, number, number] | null {
    const other = this.rays.find((one) => one !== ray && one.isSelecting && one.isTracked && !this.holding.has(one));
    return other === undefined ? null : other.xrFromRay().position;
  }

  pressed(ray: Ray, press: Press): void {
    const isHelping = press === "select" && [...this.holding.values()].some(({ isThing }) => isThing);
    if (this.holding.has(ray) || isHelping) {
      return;
    }
    const target: Target = this.target(ray);
    if (press === "squeeze") {
      this.takeWorld(ray, press, target.distance);
      return;
    }
    switch (target.kind) {
      case "panel":
        this.pressPanel(ray, target);
        return;
      case "object":
        this.desk.store.learn({ step: "place", object: target.name });
        return;
      case "thing":
        this.takeThing(ray, target);
        return;
      case "world":
        this.takeWorld(ray, press, target.distance);
        return;
    }
  }

  released(ray: Ray, press: Press): void {
    const held = this.holding.get(ray);
    if (held?.press === press) {
      this.holding.delete(ray);
      held.drag.end();
    }
  }

  private hold(ray: Ray, press: Press, drag: Drag | null, distance: number, isThing: boolean): void {
    if (drag !== null) {
      this.holding.set(ray, { drag, press, distance, isThing });
    }
  }

  private pressPanel(ray: Ray, { at, distance }: Extract<Target, { kind: "panel" }>): void {
    if (at.part === "button") {
      if (at.button.button.isDisabled !== true) {
        at.button.button.run();
      }
    } else if (at.part === "head") {
      const drag = carriedDrag(ray.xrFromRay(), poseOf(this.panel.root), (pose) => place(this.panel.root, pose));
      this.hold(ray, "select", drag, distance, false);
    }
  }

  private takeThing(ray: Ray, { what, distance }: Extract<Target, { kind: "thing" }>): void {
    const xrFromRay = ray.xrFromRay();
    const { mapFromXr } = this.desk.store.get("alignment");
    const drag =
      what === "held"
        ? thingDrag(this.desk, mapFromXr, xrFromRay)
        : jointDrag(this.desk, mapFromXr, xrFromRay, alongRay(xrFromRay, distance), what);
    this.hold(ray, "select", drag, distance, true);
  }

  /** In the room the world stays where it is, but for placing the robot. */
  private takeWorld(ray: Ray, press: Press, distance: number): void {
    if (this.mode === "immersive-ar" && !this.isAligning) {
      return;
    }
    const { store } = this.desk;
    const xrFromRay = ray.xrFromRay();
    const drag = worldDrag(
      store.get("alignment").mapFromXr,
      xrFromRay,
      alongRay(xrFromRay, distance),
      () => store.get("hand").speed,
      (mapFromXr) => place(this.origin, poseOfMapFromXr(mapFromXr)),
      (mapFromXr) => store.aligned(mapFromXr, this.isAligning ? "robot" : "moved"),
    );
    this.hold(ray, press, drag, distance, false);
  }

  private align(isAligning: boolean): void {
    this.isAligning = isAligning;
    this.isMenuOld = true;
  }

  /** What there is to point at, in XR. */
  seen(): Seen {
    const { panel, view, desk } = this;
    const { mapFromXr, epoch } = desk.store.get("alignment");
    const root = poseOf(panel.root);
    const inXr = (point: [number, number, number]): [number, number, number] =>
      composed(root, { position: point, orientation_xyzw: [0, 0, 0, 1] }).position;
    const { title, trail, body, values, notice } = panel.shown;
    return {
      title,
      trail,
      body,
      values,
      notice,
      buttons: panel.buttons.map((one) => ({
        label: one.button.label,
        isDisabled: one.button.isDisabled === true,
        isPressed: one.button.isPressed ?? null,
        at: inXr(panel.pointOf(one)),
      })),
      head: inXr(panel.headPoint),
      things: view.teach.graspables().map(({ what, nodes }) => ({ what, at: this.inXr(this.pointing.middleOf(nodes)) })),
      robot: this.robot.visible ? this.inXr(this.robot.getWorldPosition(new Vector3())) : null,
      mapFromXr,
      epoch,
    };
  }

  private inXr(point: Vector3): [number, number, number] {
    const { x, y, z } = this.origin.worldToLocal(this.point.copy(point));
    return [x, y, z];
  }
}

function poseFrom({ position: p, orientation: o }: XRRigidTransform): Pose {
  return { position: [p.x, p.y, p.z], orientation_xyzw: [o.x, o.y, o.z, o.w] };
}
