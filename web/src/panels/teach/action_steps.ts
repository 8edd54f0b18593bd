// What can be done with a thing: the list of it, and the action that is being told.

import { element } from "../../dom";
import type { Action, ActionMotion, TaughtClass } from "../../protocol";
import { effectAt, firstAction, plainName, releaseOver, type Subject } from "../../teach/lesson";
import { TEACH, words } from "../../text";
import { sizeOf } from "../../view/class_model";
import { choiceField, CM, DEGREES, type Field, numberField, sliderField, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { dragTools } from "./drag_tools";
import { button, type Desk, goTo, isAt, row, type StepView, withSubject } from "./step";

export function actionsStep(desk: Desk, { object, of }: Subject): StepView {
  const empty = element("p", { class: "empty" }, TEACH.actionsEmpty);
  const none = element("p", { class: "aside" }, TEACH.noContainer);
  const list = element("ul", { class: "things" });
  const open = (kind: ActionMotion["kind"]) => (): void => {
    const [target] = targets(desk, of);
    const action = firstAction(kind, of, target ?? null, sizeOf(target ?? { parts: [] }));
    desk.store.learn({ step: "action", object: object.name, name: "" }, { pose: null, grasp: null, action });
  };
  const into = button(TEACH.addPutInto, open("put_into"), { icon: "add" });
  const joint = button(TEACH.addJoint, open("joint"), { icon: "add" });
  return {
    title: TEACH.actionsTitle(of.name),
    body: TEACH.actionsBody,
    nodes: [
      empty,
      list,
      row(into, joint),
      none,
      row(
        button(TEACH.back, () => goTo(desk, "grasps")),
        button(TEACH.finish, () => desk.store.learn({ step: "overview" }), { primary: true }),
      ),
    ],
    show() {
      withSubject(desk, (subject) => {
        const { actions, movable, joints } = subject.of;
        empty.hidden = actions.length > 0;
        joint.hidden = joints.length === 0;
        into.hidden = !movable;
        into.disabled = targets(desk, subject.of).length === 0;
        none.hidden = into.hidden || !into.disabled;
        list.replaceChildren(...actions.map((action) => item(desk, subject, action)));
      });
    },
  };
}

/** Classes that a thing can be put into: those of the home but its own. */
function targets(desk: Desk, of: TaughtClass): TaughtClass[] {
  return (desk.store.get("teaching")?.classes ?? []).filter((other) => other.name !== of.name && !other.movable);
}

function item(desk: Desk, { object, of }: Subject, action: Action): HTMLElement {
  const name = words(action.name);
  const { motion } = action;
  const what = motion.kind === "joint" ? `${words(motion.joint)}: ${words(motion.effect)}` : `into ${words(motion.class)}`;
  return element(
    "li",
    {},
    element("b", {}, name),
    element("span", { class: "aside" }, what),
    button(
      TEACH.change,
      () => desk.store.learn({ step: "action", object: object.name, name: action.name }, { pose: null, grasp: null, action }),
      { name: `${TEACH.change} ${name}` },
    ),
    button(
      TEACH.forget,
      () => void desk.edits.ask({ kind: "remove_action", class: of.name, name: action.name }),
      { name: `${TEACH.forget} ${name}` },
    ),
  );
}

/** A part of the step that shows one side of the action, and is there for some kinds of it only. */
interface Side {
  readonly nodes: readonly HTMLElement[];
  show(action: Action): void;
}

export function actionStep(desk: Desk, subject: Subject, existing: string): StepView {
  const { of } = subject;
  const kind = desk.store.get("draft").action?.motion.kind ?? "put_into";
  const change = (changed: Partial<Action>): void => {
    const { action } = desk.store.get("draft");
    if (action !== null) {
      desk.store.drafted({ action: { ...action, ...changed } });
    }
  };
  const name = textField(TEACH.name, (text) => change({ name: plainName(text) }));
  name.node.hidden = existing !== "";
  const grasps = of.grasps.map((grasp) => [grasp.name, words(grasp.name)] as const);
  const grasp = choiceField(TEACH.withGrasp, [["", TEACH.anyGrasp], ...grasps], (chosen) =>
    change({ grasp: chosen === "" ? null : chosen }),
  );
  const near = distanceField(TEACH.nearest, 0, change, desk);
  const far = distanceField(TEACH.farthest, 1, change, desk);
  const side = kind === "joint" ? jointSide(desk, subject, change) : intoSide(desk, subject, change);
  const save = button(TEACH.save, () => void run(), { primary: true });
  const run = async (): Promise<void> => {
    const lesson = desk.store.get("lesson");
    const { action } = desk.store.get("draft");
    if (action === null) {
      return;
    }
    const outcome = await desk.edits.ask({ kind: "put_action", class: of.name, action });
    if (outcome.kind === "accepted" && isAt(desk, lesson)) {
      goTo(desk, "actions");
    }
  };
  return {
    title: TEACH.actionTitle(of.name),
    body: kind === "joint" ? TEACH.jointBody : TEACH.putIntoBody,
    nodes: [
      name.node,
      ...side.nodes,
      grasp.node,
      element("div", { class: "three" }, near.node, far.node),
      row(button(TEACH.cancel, () => goTo(desk, "actions")), save),
    ],
    show() {
      const { action } = desk.store.get("draft");
      if (action !== null) {
        name.show(action.name);
        grasp.show(action.grasp ?? "");
        near.show(action.approach?.distance_m[0] ?? 0.8);
        far.show(action.approach?.distance_m[1] ?? 1.25);
        side.show(action);
        const { motion } = action;
        save.disabled = action.name === "" || (motion.kind === "joint" ? motion.effect === "" : motion.class === "");
      }
    },
  };
}

function distanceField(
  label: string,
  index: 0 | 1,
  change: (changed: Partial<Action>) => void,
  desk: Desk,
): Field<number> {
  return numberField(label, CM, (value) => {
    const [near, far] = desk.store.get("draft").action?.approach?.distance_m ?? [0.8, 1.25];
    change({ approach: { distance_m: index === 0 ? [value, far] : [near, value] } });
  });
}

function intoSide(desk: Desk, { of }: Subject, change: (changed: Partial<Action>) => void): Side {
  const motionNow = (): Extract<ActionMotion, { kind: "put_into" }> | null => {
    const motion = desk.store.get("draft").action?.motion;
    return motion?.kind === "put_into" ? motion : null;
  };
  const classes = targets(desk, of).map((other) => [other.name, words(other.name)] as const);
  const into = choiceField(TEACH.into, classes, (name) => {
    const target = targets(desk, of).find((other) => other.name === name);
    const motion = motionNow();
    if (target !== undefined && motion !== null) {
      change({ motion: { ...motion, class: name, ...releaseOver(sizeOf(target)) } });
    }
  });
  const pose = poseFields((target_from_object) => {
    const motion = motionNow();
    if (motion !== null) {
      change({ motion: { ...motion, target_from_object } });
    }
  });
  const missing = element("p", { class: "aside" }, TEACH.noTarget);
  return {
    nodes: [into.node, missing, dragTools(desk.store), pose.node],
    show({ motion }) {
      if (motion.kind === "put_into") {
        into.show(motion.class);
        pose.show(motion.target_from_object);
        const objects = desk.store.get("teaching")?.objects ?? [];
        missing.hidden = objects.some((object) => object.class === motion.class);
      }
    },
  };
}

function jointSide(desk: Desk, { of }: Subject, change: (changed: Partial<Action>) => void): Side {
  const set = (changed: Partial<Extract<ActionMotion, { kind: "joint" }>>): void => {
    const motion = desk.store.get("draft").action?.motion;
    if (motion?.kind === "joint") {
      const next = { ...motion, ...changed };
      const effect = "effect" in changed ? next.effect : effectAt(of, next.joint, next.termination, next.effect);
      change({ motion: { ...next, effect } });
    }
  };
  const part = choiceField(TEACH.part, of.joints.map(({ name }) => [name, words(name)] as const), (name) => {
    const joint = of.joints.find((other) => other.name === name);
    if (joint !== undefined) {
      set({ joint: name, initiation: joint.range[0], termination: joint.range[1] });
    }
  });
  const sliders = element("div", {});
  let shownJoint = "";
  let begins: Field<number> | null = null;
  let ends: Field<number> | null = null;
  const contact = choiceField(TEACH.contact, [["grasp", TEACH.grasps], ["push", TEACH.pushes]], (chosen) =>
    set({ contact: chosen === "push" ? "push" : "grasp" }),
  );
  const effect = textField(TEACH.effect, (text) => set({ effect: plainName(text) }));
  return {
    nodes: [part.node, sliders, contact.node, effect.node],
    show({ motion }) {
      if (motion.kind !== "joint") {
        return;
      }
      const joint = of.joints.find((other) => other.name === motion.joint);
      if (joint !== undefined && joint.name !== shownJoint) {
        shownJoint = joint.name;
        const turns = joint.kind === "revolute";
        const unit = turns ? DEGREES : CM;
        begins = sliderField(TEACH.begins(turns), unit, joint.range, (initiation) => set({ initiation }));
        ends = sliderField(TEACH.ends(turns), unit, joint.range, (termination) => set({ termination }));
        sliders.replaceChildren(begins.node, ends.node);
      }
      part.show(motion.joint);
      begins?.show(motion.initiation ?? joint?.range[0] ?? 0);
      ends?.show(motion.termination);
      contact.show(motion.contact);
      effect.show(motion.effect);
    },
  };
}
