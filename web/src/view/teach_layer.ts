// What is being taught, in the scene: the object in its own colour, the grippers at it, where its joint begins and ends,
// and the gizmo that moves one of them. Reads lesson and draft of the store; a drag changes the draft.

import { type Camera, Color, Group, MeshLambertMaterial, type Object3D } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";

import { composed, IDENTITY, place, poseOf } from "../frames";
import { REGION_COLOURS, regionColour } from "../palette";
import type { Action, Grasp, Pose } from "../protocol";
import type { Store } from "../store";
import { dragTo, heldOf, targetOf } from "../teach/drag";
import { type Draft, type Lesson, subjectOf, type Subject } from "../teach/lesson";
import { ClassModel } from "./class_model";
import { gripper } from "./gripper";

const GHOST_OPACITY = 0.35;

/** What the layer asks of those around it. */
export interface TeachHost {
  /** Something has changed: draw. */
  request(): void;
  /** A drag begins or ends: what else a drag would move keeps still. */
  dragging(isDragging: boolean): void;
  /** What was dragged has been let go: it may be saved. */
  dropped(): void;
  /** This object is drawn here; nobody else should. */
  hide(object: string | null): void;
}

/** Something that a hand can take hold of. */
export interface Graspable {
  /** The thing of the step as a whole, or where a joint's action begins or ends. */
  readonly what: "held" | "initiation" | "termination";
  readonly nodes: readonly Object3D[];
}

export class TeachLayer {
  readonly root = new Group();
  /** The gizmo, which belongs to the scene itself. */
  readonly gizmo: Object3D;
  private readonly controls: TransformControls;
  private readonly solid = new MeshLambertMaterial();
  private readonly ghost = new MeshLambertMaterial({
    transparent: true,
    opacity: GHOST_OPACITY,
    depthWrite: false,
  });
  /** What the gizmo is at; below the root, at a pose in the world. */
  private readonly held = new Group();
  private model: ClassModel | null = null;
  private readonly ghosts: ClassModel[] = [];
  private readonly grippers = new Group();
  private start: Pose | null = null;
  private shownAs = "";
  private isByHand = false;

  constructor(
    private readonly store: Store,
    camera: Camera,
    canvas: HTMLElement,
    private readonly host: TeachHost,
  ) {
    this.controls = new TransformControls(camera, canvas);
    this.controls.setSpace("local");
    this.controls.setSize(0.85);
    // Axes that people with any colour vision can tell apart.
    this.controls.setColors(REGION_COLOURS[5] ?? 0, REGION_COLOURS[2] ?? 0, REGION_COLOURS[0] ?? 0, 0xffffff);
    this.gizmo = this.controls.getHelper();
    this.root.add(this.held, this.grippers);
    this.controls.addEventListener("change", () => host.request());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      const isDragging = value === true;
      host.dragging(isDragging);
      if (isDragging) {
        this.start = poseOf(this.held);
      } else if (this.start !== null) {
        this.start = null;
        host.dropped();
        this.show();
      }
    });
    this.controls.addEventListener("objectChange", () => this.drag());
    store.watch(["lesson", "draft", "teaching"], () => this.show());
    store.watch(["hand"], () => {
      this.controls.setMode(store.get("hand").mode === "turn" ? "rotate" : "translate");
      host.request();
    });
  }

  /** In a headset things are taken by hand, and there is no gizmo. */
  takenByHand(isByHand: boolean): void {
    this.isByHand = isByHand;
    this.shownAs = "";
    this.show();
  }

  /** What a hand can take hold of, what it rather takes first. */
  graspables(): readonly Graspable[] {
    const { store, model, ghosts } = this;
    const lesson = store.get("lesson");
    const { action } = store.get("draft");
    if (lesson.step === "action" && action?.motion.kind === "joint") {
      const { joint } = action.motion;
      return [
        { what: "termination", nodes: ghosts[1]?.movedBy(joint) ?? [] },
        { what: "initiation", nodes: ghosts[0]?.movedBy(joint) ?? [] },
      ];
    }
    if (model === null || heldOf(lesson, store.get("draft"), store.get("teaching")) === null) {
      return [];
    }
    const put = ghosts[0]?.root ?? this.held;
    return [{ what: "held", nodes: [lesson.step === "place" ? model.root : put] }];
  }

  /** The gizmo has moved what it holds. */
  private drag(): void {
    const at = this.start && dragTo(this.store, this.start, poseOf(this.held));
    if (at !== null) {
      place(this.held, at);
    }
  }

  private show(): void {
    const { store } = this;
    const lesson = store.get("lesson");
    const subject = subjectOf(lesson, store.get("teaching"));
    const draft = store.get("draft");
    const as = JSON.stringify([lesson, subject, draft.grasp?.aperture_m, kindOf(draft.action)]);
    // Nothing is taken out of a hand that holds it.
    if (as !== this.shownAs && this.start === null) {
      this.shownAs = as;
      this.rebuild(subject);
    }
    if (subject !== null) {
      this.arrange(subject, lesson, draft);
    }
    this.host.request();
  }

  private rebuild(subject: Subject | null): void {
    this.controls.detach();
    this.model?.dispose();
    this.model = null;
    for (const ghost of this.ghosts.splice(0)) {
      ghost.dispose();
    }
    this.grippers.clear();
    this.held.clear();
    this.host.hide(subject?.object.name ?? null);
    if (subject === null) {
      return;
    }
    const colour = new Color(regionColour(subject.object.colour_index));
    this.solid.color.copy(colour);
    this.ghost.color.copy(colour);
    const { step } = this.store.get("lesson");
    // A hand is seen through what it holds.
    this.model = new ClassModel(subject.of, step === "grasp" || step === "grasps" ? this.ghost : this.solid);
    this.root.add(this.model.root);
    const { grasp, action } = this.store.get("draft");
    if (step === "action" && action !== null) {
      // A joint begins and ends somewhere; what is put somewhere ends there.
      for (let n = action.motion.kind === "joint" ? 2 : 1; n > 0; n--) {
        const ghost = new ClassModel(subject.of, this.ghost);
        this.ghosts.push(ghost);
        this.root.add(ghost.root);
      }
    }
    if (step === "grasp" && grasp !== null) {
      this.held.add(gripper(grasp.aperture_m, this.solid));
    }
    const held = heldOf(this.store.get("lesson"), this.store.get("draft"), this.store.get("teaching"));
    if (held !== null && !this.isByHand) {
      this.controls.attach(this.held);
    }
  }

  /** Puts everything where draft and home say. */
  private arrange(subject: Subject, lesson: Lesson, draft: Draft): void {
    const worldFromObject = (lesson.step === "place" ? draft.pose : null) ?? subject.object.pose;
    if (this.model !== null) {
      place(this.model.root, worldFromObject);
    }
    this.arrangeGrippers(subject, lesson, draft, worldFromObject);
    if (lesson.step === "place" && this.start === null) {
      place(this.held, worldFromObject);
    }
    const motion = draft.action?.motion;
    if (lesson.step !== "action" || motion === undefined) {
      return;
    }
    if (motion.kind === "joint") {
      const ends = [motion.initiation ?? 0, motion.termination];
      this.ghosts.forEach((ghost, index) => {
        place(ghost.root, worldFromObject);
        ghost.pose(motion.joint, ends[index] ?? 0);
      });
      return;
    }
    const target = targetOf(motion.class, this.store.get("teaching"));
    const [put] = this.ghosts;
    if (put !== undefined) {
      put.root.visible = target !== null;
      const at = composed(target ?? IDENTITY, motion.target_from_object);
      place(put.root, at);
      if (this.start === null) {
        place(this.held, at);
      }
    }
  }

  private arrangeGrippers(subject: Subject, lesson: Lesson, draft: Draft, worldFromObject: Pose): void {
    const shown = (grasp: Grasp): boolean =>
      (lesson.step === "grasps" || lesson.step === "grasp") && !("name" in lesson && grasp.name === lesson.name);
    this.grippers.clear();
    for (const grasp of subject.of.grasps.filter(shown)) {
      const drawn = gripper(grasp.aperture_m, lesson.step === "grasps" ? this.solid : this.ghost);
      place(drawn, composed(worldFromObject, grasp.object_from_tool));
      this.grippers.add(drawn);
    }
    if (lesson.step === "grasp" && draft.grasp !== null && this.start === null) {
      place(this.held, composed(worldFromObject, draft.grasp.object_from_tool));
    }
  }
}

function kindOf(action: Action | null): string {
  if (action === null) {
    return "";
  }
  return action.motion.kind === "joint" ? `joint ${action.motion.joint}` : `put into ${action.motion.class}`;
}
