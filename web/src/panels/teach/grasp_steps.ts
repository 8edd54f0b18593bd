// Ways to hold a thing: the list of them, and the one that is being shown.

import { element } from "../../dom";
import type { Grasp } from "../../protocol";
import { type Desk, goTo, withSubject } from "../../teach/desk";
import { beginGrasp, canSaveGrasp, changeGrasp, forgetGrasp, openGrasp, saveGrasp } from "../../teach/holding";
import { plainName, type Subject } from "../../teach/lesson";
import { TEACH, words } from "../../text";
import { checkField, CM, numberField, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { dragTools } from "./drag_tools";
import { button, row, type StepView } from "./step";

export function graspsStep(desk: Desk, { of }: Subject): StepView {
  const empty = element("p", { class: "empty" }, TEACH.graspsEmpty);
  const list = element("ul", { class: "things" });
  const add = button(TEACH.addGrasp, () => openGrasp(desk, null), { icon: "add" });
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

function item(desk: Desk, subject: Subject, grasp: Grasp): HTMLElement {
  const name = words(grasp.name);
  return element(
    "li",
    {},
    element("b", {}, name),
    element("span", { class: "aside" }, grasp.provenance),
    button(TEACH.change, () => openGrasp(desk, grasp), { name: `${TEACH.change} ${name}` }),
    button(TEACH.forget, () => forgetGrasp(desk, subject, grasp.name), { name: `${TEACH.forget} ${name}` }),
  );
}

export function graspStep(desk: Desk, subject: Subject, existing: string): StepView {
  const { of } = subject;
  const change = (changed: Partial<Grasp>): void => changeGrasp(desk, changed);
  const name = textField(TEACH.name, (text) => change({ name: plainName(text) }));
  const pose = poseFields((object_from_tool) => change({ object_from_tool }));
  const opening = numberField(TEACH.opening, CM, (aperture_m) => change({ aperture_m }));
  const symmetric = checkField(TEACH.symmetric, (yaw_symmetric) => change({ yaw_symmetric }));
  const save = button(TEACH.save, () => void saveGrasp(desk, subject), { primary: true });
  // A name is what a thing is changed by: another one would make another grasp.
  name.node.hidden = existing !== "";
  return {
    title: TEACH.graspTitle(of.name),
    body: TEACH.graspBody,
    nodes: [
      name.node,
      row(
        button(TEACH.fromSide, () => beginGrasp(desk, "side")),
        button(TEACH.fromAbove, () => beginGrasp(desk, "above")),
      ),
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
        save.disabled = !canSaveGrasp(desk);
      }
    },
  };
}

