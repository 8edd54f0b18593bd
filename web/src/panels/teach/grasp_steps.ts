// Ways to hold a thing: the list of them, and the one that is being shown.

import { element } from "../../dom";
import type { Grasp } from "../../protocol";
import { firstGrasp, plainName, type Subject } from "../../teach/lesson";
import { TEACH, words } from "../../text";
import { sizeOf } from "../../view/class_model";
import { checkField, CM, numberField, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { dragTools } from "./drag_tools";
import { button, type Desk, goTo, isAt, row, type StepView, withSubject } from "./step";

export function graspsStep(desk: Desk, { object, of }: Subject): StepView {
  const empty = element("p", { class: "empty" }, TEACH.graspsEmpty);
  const list = element("ul", { class: "things" });
  const add = button(TEACH.addGrasp, () =>
    withSubject(desk, (subject) => {
      desk.store.learn({ step: "grasp", object: object.name, name: "" }, { pose: null, action: null, grasp: begin(desk, subject, "side") });
    }),
    { icon: "add" },
  );
  return {
    title: TEACH.graspsTitle(of.name),
    body: TEACH.graspsBody,
    nodes: [
      empty,
      list,
      row(add),
      row(button(TEACH.back, () => goTo(desk, "place")), button(TEACH.next, () => goTo(desk, "actions"), { primary: true })),
    ],
    show() {
      withSubject(desk, (subject) => {
        empty.hidden = subject.of.grasps.length > 0;
        list.replaceChildren(...subject.of.grasps.map((grasp) => item(desk, subject, grasp)));
      });
    },
  };
}

function item(desk: Desk, { object, of }: Subject, grasp: Grasp): HTMLElement {
  const name = words(grasp.name);
  return element(
    "li",
    {},
    element("b", {}, name),
    element("span", { class: "aside" }, grasp.provenance),
    button(
      TEACH.change,
      () => desk.store.learn({ step: "grasp", object: object.name, name: grasp.name }, { pose: null, action: null, grasp }),
      { name: `${TEACH.change} ${name}` },
    ),
    button(
      TEACH.forget,
      () => void desk.edits.ask({ kind: "remove_grasp", class: of.name, name: grasp.name }),
      { name: `${TEACH.forget} ${name}` },
    ),
  );
}

function begin(desk: Desk, { of }: Subject, from: "side" | "above"): Grasp {
  return firstGrasp(from, of, sizeOf(of), desk.store.get("teaching")?.aperture_max_m ?? 0.1);
}

export function graspStep(desk: Desk, { of }: Subject, existing: string): StepView {
  const change = (changed: Partial<Grasp>): void => {
    const { grasp } = desk.store.get("draft");
    if (grasp !== null) {
      desk.store.drafted({ grasp: { ...grasp, ...changed } });
    }
  };
  const name = textField(TEACH.name, (text) => change({ name: plainName(text) }));
  const pose = poseFields((object_from_tool) => change({ object_from_tool }));
  const opening = numberField(TEACH.opening, CM, (aperture_m) => change({ aperture_m }));
  const symmetric = checkField(TEACH.symmetric, (yaw_symmetric) => change({ yaw_symmetric }));
  const start = (from: "side" | "above"): void =>
    withSubject(desk, (subject) => {
      const { object_from_tool, aperture_m } = begin(desk, subject, from);
      change({ object_from_tool, aperture_m });
    });
  const save = button(TEACH.save, () => void run(), { primary: true });
  const run = async (): Promise<void> => {
    const lesson = desk.store.get("lesson");
    const { grasp } = desk.store.get("draft");
    if (grasp === null) {
      return;
    }
    const outcome = await desk.edits.ask({ kind: "put_grasp", class: of.name, grasp });
    if (outcome.kind === "accepted" && isAt(desk, lesson)) {
      goTo(desk, "grasps");
    }
  };
  // A name is what a thing is changed by: another one would make another grasp.
  name.node.hidden = existing !== "";
  return {
    title: TEACH.graspTitle(of.name),
    body: TEACH.graspBody,
    nodes: [
      name.node,
      row(button(TEACH.fromSide, () => start("side")), button(TEACH.fromAbove, () => start("above"))),
      dragTools(desk.store),
      pose.node,
      opening.node,
      symmetric.node,
      row(button(TEACH.cancel, () => goTo(desk, "grasps")), save),
    ],
    show() {
      const { grasp } = desk.store.get("draft");
      if (grasp !== null) {
        name.show(grasp.name);
        pose.show(grasp.object_from_tool);
        opening.show(grasp.aperture_m);
        symmetric.show(grasp.yaw_symmetric);
        save.disabled = grasp.name === "";
      }
    },
  };
}

