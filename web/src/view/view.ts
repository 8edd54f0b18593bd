// The live view: reads the store and draws it. A frame is drawn only when something has changed.

import { Box3, Group, PCFShadowMap, type PerspectiveCamera, Scene, WebGLRenderer } from "three";

import { element } from "../dom";
import { Z_UP_TO_Y_UP } from "../frames";
import type { State } from "../protocol";
import type { Store } from "../store";
import { targetOf } from "../teach/drag";
import { subjectOf } from "../teach/lesson";
import { clockText, sceneSummary } from "../text";
import { Bodies } from "./bodies";
import { CameraRig } from "./camera_rig";
import { Labels } from "./labels";
import { MapLayer } from "./map_layer";
import { PathLayer } from "./path_layer";
import { Quality } from "./quality";
import { RegionsLayer } from "./regions_layer";
import { Surroundings } from "./surroundings";
import { TeachLayer } from "./teach_layer";
import { currentTheme, onThemeChange } from "./theme";

/** Longer gaps are pauses, not slow frames. */
const FRAME_GAP_MAX_SECS = 0.1;
const SUMMARY_MILLIS = 5000;
/** Below this, metres, nothing belongs to a home. */
const UNDERGROUND_M = -2;

/** How far the camera is from what is taught, metres, by what is taught of it. */
const LOOK_DISTANCE_M = { place: 3.2, grasps: 0.9, grasp: 0.9, actions: 3.2, action: 2 } as const;

/** Eyes of somebody in a headset. */
export interface Eyes {
  readonly camera: PerspectiveCamera;
  /** The room is seen behind the picture. */
  readonly seesRoom: boolean;
  /** Comes before each picture. */
  update(frame: XRFrame, dtSecs: number): void;
  /** Where on the floor, in the wire's world, they look. */
  lookedAt(): [number, number];
}

/** Draws into the stage for as long as the page is open; null where there is no WebGL 2. */
export function createView(store: Store, stage: HTMLElement, dropped: () => void): View | null {
  const canvas = element("canvas", { tabindex: "0", role: "img" });
  try {
    const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    return new View(store, stage, canvas, renderer, dropped);
  } catch {
    return null;
  }
}

export class View {
  private readonly scene = new Scene();
  /** Everything of the wire, turned from z up to y up. */
  readonly world = new Group();
  private readonly surroundings = new Surroundings(this.scene);
  readonly bodies = new Bodies();
  private readonly map = new MapLayer();
  private readonly regions = new RegionsLayer();
  private readonly path = new PathLayer();
  private readonly labels = new Labels();
  private readonly quality = new Quality();
  private readonly rig: CameraRig;
  readonly teach: TeachLayer;
  private eyes: Eyes | null = null;
  private lookedFor = "";
  private readonly visibleLabels = { object: true, region: true };
  private readonly draw = (nowMillis: number): void => this.frame(nowMillis);
  private readonly drawForEyes = (nowMillis: number, frame?: XRFrame): void => this.frameForEyes(nowMillis, frame);
  private requested = false;
  private lastMillis = 0;
  private live: State | null = null;
  private width = 1;
  private height = 1;

  constructor(
    private readonly store: Store,
    private readonly stage: HTMLElement,
    private readonly canvas: HTMLCanvasElement,
    readonly renderer: WebGLRenderer,
    dropped: () => void,
  ) {
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = PCFShadowMap;
    renderer.shadowMap.autoUpdate = false;
    this.rig = new CameraRig(canvas, () => this.request());
    this.teach = new TeachLayer(store, this.rig.camera, canvas, {
      request: () => this.request(),
      dragging: (isDragging) => {
        this.rig.controls.enabled = !isDragging;
      },
      dropped,
      hide: (object) => this.bodies.hide(object === null ? null : `believed ${object}`),
    });
    this.world.quaternion.copy(Z_UP_TO_Y_UP);
    this.world.add(
      this.bodies.root,
      this.map.root,
      this.regions.root,
      this.path.root,
      this.teach.root,
    );
    this.scene.add(this.surroundings.root, this.world, this.teach.gizmo);
    this.world.updateMatrixWorld(true);
    stage.prepend(canvas, this.labels.root);

    this.applyTheme();
    onThemeChange(() => this.applyTheme());
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
    this.watch();
    this.summarise();
    setInterval(() => this.summarise(), SUMMARY_MILLIS);
  }

  private watch(): void {
    const { store } = this;
    store.watch(["scenes"], () => {
      this.bodies.show(store.get("scenes"));
      // New bodies stand where their scene has them, until the state is applied to them too.
      this.live = null;
      this.world.updateMatrixWorld(true);
      this.fit();
      this.renderer.shadowMap.needsUpdate = true;
      this.request();
    });
    store.watch(["map"], () => {
      this.map.show(store.get("map"), currentTheme());
      if (!store.get("scenes").has("home")) {
        this.fit();
      }
      this.request();
    });
    store.watch(["aosm"], () => {
      this.regions.show(store.get("aosm")?.regions ?? []);
    });
    store.watch(["aosm", "teaching"], () => {
      this.labels.show(store.get("aosm"), store.get("teaching"));
      this.request();
    });
    store.watch(["path"], () => {
      this.path.showPath(store.get("path"));
      this.request();
    });
    store.watch(["lesson"], () => this.look());
    store.watch(["lesson", "wishes"], () => {
      // Where the robot can stand is in the way of who looks closely at a thing.
      const { step } = store.get("lesson");
      this.regions.root.visible = store.get("wishes").regions && (step === "overview" || step === "actions");
      this.visibleLabels.region = this.regions.root.visible;
      this.request();
    });
    store.watch(["live"], () => this.request());
    store.watch(["wishes"], () => {
      const wishes = store.get("wishes");
      this.map.root.visible = wishes.map;
      this.visibleLabels.object = wishes.labels;
      this.rig.follow(wishes.follow);
      this.request();
    });
  }

  /** Spreads light and camera over all there is. */
  private fit(): void {
    const box = new Box3();
    for (const body of this.bodies.root.children.flatMap((source) => source.children)) {
      // What is kept deep under the floor until it is needed is no part of the home.
      if (body.position.z > UNDERGROUND_M) {
        box.expandByObject(body);
      }
    }
    if (!this.store.get("scenes").has("home")) {
      // A stored home has no walls but those of its map.
      box.expandByObject(this.map.root);
    }
    this.surroundings.fit(box);
    this.rig.fit(box);
  }

  /** Where on the floor, in the wire's world, a person looks. */
  lookedAt(): [number, number] {
    return (this.eyes ?? this.rig).lookedAt();
  }

  /** Goes near what is taught, once for each step. */
  private look(): void {
    const lesson = this.store.get("lesson");
    const subject = subjectOf(lesson, this.store.get("teaching"));
    const looked = subject === null ? "" : `${lesson.step} ${subject.object.name}`;
    if (looked !== this.lookedFor) {
      this.lookedFor = looked;
      if (subject !== null && lesson.step !== "overview" && lesson.step !== "class") {
        const motion = this.store.get("draft").action?.motion;
        const target = motion?.kind === "put_into" ? targetOf(motion.class, this.store.get("teaching")) : null;
        this.rig.lookAt((target ?? subject.object.pose).position, LOOK_DISTANCE_M[lesson.step]);
        this.request();
      }
    }
  }

  /** Draws what these eyes see, as often as their headset asks, until they close (null). */
  wear(eyes: Eyes | null): void {
    this.eyes = eyes;
    this.surroundings.lookedAtBy(eyes);
    this.teach.takenByHand(eyes !== null);
    this.labels.root.hidden = eyes !== null;
    this.renderer.setAnimationLoop(eyes === null ? null : this.drawForEyes);
    this.renderer.shadowMap.needsUpdate = true;
    if (eyes === null) {
      this.resize();
    }
  }

  /** Asks for a frame. */
  private request(): void {
    // Pictures for a headset come by themselves.
    if (!this.requested && this.eyes === null) {
      this.requested = true;
      requestAnimationFrame(this.draw);
    }
  }

  /** Draws one frame. Allocates nothing of its own while bodies only move. */
  private frame(nowMillis: number): void {
    this.requested = false;
    if (this.eyes !== null) {
      return;
    }
    const gapSecs = this.gapSecs(nowMillis);
    const dtSecs = Math.min(gapSecs, FRAME_GAP_MAX_SECS);
    if (gapSecs < 4 * FRAME_GAP_MAX_SECS && this.quality.note(1000 * gapSecs)) {
      this.resize();
    }
    const live = this.move();
    const carried = this.rig.update(live, dtSecs);
    const { camera, controls } = this.rig;
    const lowering = this.bodies.cutaway.update(camera.position, controls.target, dtSecs);
    this.renderer.shadowMap.needsUpdate ||= lowering;
    this.renderer.render(this.scene, camera);
    this.labels.update(this.world, camera, this.width, this.height, this.visibleLabels);
    this.stage.dataset["bodies"] = String(this.bodies.count);
    if (carried || lowering) {
      this.request();
    }
  }

  /** Draws one frame for a headset. */
  private frameForEyes(nowMillis: number, frame: XRFrame | undefined): void {
    const { eyes } = this;
    if (eyes === null || frame === undefined) {
      return;
    }
    const dtSecs = Math.min(this.gapSecs(nowMillis), FRAME_GAP_MAX_SECS);
    this.move();
    eyes.update(frame, dtSecs);
    // Who is in the home has no walls in the way.
    const { position } = eyes.camera;
    this.bodies.cutaway.update(position, position, dtSecs);
    this.renderer.render(this.scene, eyes.camera);
  }

  private gapSecs(nowMillis: number): number {
    const gap = (nowMillis - this.lastMillis) / 1000;
    this.lastMillis = nowMillis;
    return Math.max(0, gap);
  }

  /** Moves all to where the latest state has it. */
  private move(): State | null {
    const live = this.store.get("live");
    if (live !== this.live) {
      this.live = live;
      if (live !== null) {
        this.bodies.move(live);
      }
      this.path.showBase(live);
      this.renderer.shadowMap.needsUpdate = true;
    }
    return live;
  }

  private resize(): void {
    if (this.eyes !== null) {
      return;
    }
    this.width = Math.max(1, this.stage.clientWidth);
    this.height = Math.max(1, this.stage.clientHeight);
    this.renderer.setPixelRatio(this.quality.pixelRatio);
    this.renderer.setSize(this.width, this.height, false);
    this.rig.resize(this.width, this.height);
    this.request();
  }

  private applyTheme(): void {
    const theme = currentTheme();
    this.surroundings.setTheme(theme);
    this.bodies.setTheme(theme);
    this.path.setTheme(theme);
    this.map.show(this.store.get("map"), theme);
    this.request();
  }

  private summarise(): void {
    const time = clockText(this.store.get("live")?.time_secs ?? 0);
    this.canvas.setAttribute("aria-label", sceneSummary(this.bodies.count, time));
  }
}
