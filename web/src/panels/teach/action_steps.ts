// What can be done with a thing: the list of it, and the action that is being told.

import { element } from "../../dom";
import type { Action } from "../../protocol";
import { type Desk, goTo, withSubject } from "../../teach/desk";
import {
  APPROACH_M,
  canSaveAction,
  changeAction,
  changeJoint,
  changePut,
  chooseJoint,
  choosePut,
  forgetAction,
  type JointMotion,
  newAction,
  openAction,
  saveAction,
  targets,
} from "../../teach/doing";
import { plainName, type Subject } from "../../teach/lesson";
import { TEACH, words } from "../../text";
import { choiceField, CM, DEGREES, type Field, numberField, sliderField, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { dragTools } from "./drag_tools";
import { button, row, type StepView } from "./step";

export function actionsStep(desk: Desk, { of }: Subject): StepView {
  const empty = element("p", { class: "empty" }, TEACH.actionsEmpty);
  const none = element("p", { class: "aside" }, TEACH.noContainer);
  const list = element("ul", { class: "things" });
  const into = button(TEACH.addPutInto, () => newAction(desk, "put_into"), { icon: "add" });
  const joint = button(TEACH.addJoint, () => newAction(desk, "joint"), { icon: "add" });
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

function item(desk: Desk, subject: Subject, action: Action): HTMLElement {
  const name = words(action.name);
  const { motion } = action;
  const what = motion.kind === "joint" ? `${words(motion.joint)}: ${words(motion.effect)}` : `into ${words(motion.class)}`;
  return element(
    "li",
    {},
    element("b", {}, name),
    element("span", { class: "aside" }, what),
    button(TEACH.change, () => openAction(desk, subject, action), { name: `${TEACH.change} ${name}` }),
    button(TEACH.forget, () => forgetAction(desk, subject, action.name), { name: `${TEACH.forget} ${name}` }),
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
  const change = (changed: Partial<Action>): void => changeAction(desk, changed);
  const name = textField(TEACH.name, (text) => change({ name: plainName(text) }));
  name.node.hidden = existing !== "";
  const grasps = of.grasps.map((grasp) => [grasp.name, words(grasp.name)] as const);
  const grasp = choiceField(TEACH.withGrasp, [["", TEACH.anyGrasp], ...grasps], (chosen) =>
    change({ grasp: chosen === "" ? null : chosen }),
  );
  const near = distanceField(TEACH.nearest, 0, change, desk);
  const far = distanceField(TEACH.farthest, 1, change, desk);
  const side = kind === "joint" ? jointSide(desk, subject) : intoSide(desk, subject);
  const save = button(TEACH.save, () => void saveAction(desk, subject), { primary: true });
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
        near.show(action.approach?.distance_m[0] ?? APPROACH_M[0]);
        far.show(action.approach?.distance_m[1] ?? APPROACH_M[1]);
        side.show(action);
        save.disabled = !canSaveAction(desk);
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
    const [near, far] = desk.store.get("draft").action?.approach?.distance_m ?? APPROACH_M;
    change({ approach: { distance_m: index === 0 ? [value, far] : [near, value] } });
  });
}

function intoSide(desk: Desk, subject: Subject): Side {
  const classes = targets(desk, subject.of).map((other) => [other.name, words(other.name)] as const);
  const into = choiceField(TEACH.into, classes, (name) => choosePut(desk, subject, name));
  const pose = poseFields((target_from_object) => changePut(desk, { target_from_object }));
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

function jointSide(desk: Desk, { of }: Subject): Side {
  const set = (changed: Partial<JointMotion>): void => changeJoint(desk, of, changed);
  const joints = of.joints.map(({ name }) => [name, words(name)] as const);
  const part = choiceField(TEACH.part, joints, (name) => chooseJoint(desk, of, name));
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
