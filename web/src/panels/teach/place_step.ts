// Where a thing stands (Γ), and how large it is if it is made of a shape.

import { element } from "../../dom";
import type { Form } from "../../protocol";
import { type Desk, goTo, withSubject } from "../../teach/desk";
import { plainName, subjectOf } from "../../teach/lesson";
import { putAt, putOnFloor, renameTo, reshape, takeOut } from "../../teach/things";
import { TEACH } from "../../text";
import { checkField, type Field, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { sizeFields } from "./class_step";
import { dragTools } from "./drag_tools";
import { button, row, type StepView } from "./step";

export function placeStep(desk: Desk, object: string): StepView {
  const pose = poseFields((changed) => putAt(desk, changed));
  const floor = button(TEACH.onFloor, () => putOnFloor(desk));
  const remove = button(TEACH.remove, () => takeOut(desk, object));
  let written = object;
  const name = textField(TEACH.name, (text) => (written = plainName(text)));
  name.show(object);
  const rename = row(name.node, button(TEACH.rename, () => void renameTo(desk, object, written)));
  const size = element("div", { class: "three" });
  const movable = checkField(TEACH.movable, (carried) =>
    withSubject(desk, (subject) => reshape(desk, subject, { movable: carried })),
  );
  const sizes = element("fieldset", {}, element("legend", {}, TEACH.resize), size, movable.node);
  let fields: readonly Field<Form>[] = [];
  let shownKind = "";
  return {
    title: TEACH.placeTitle(object),
    body: TEACH.placeBody,
    nodes: [
      dragTools(desk.store),
      pose.node,
      row(floor),
      sizes,
      rename,
      row(
        button(TEACH.back, () => desk.store.learn({ step: "overview" })),
        remove,
        button(TEACH.next, () => goTo(desk, "grasps"), { primary: true }),
      ),
    ],
    show() {
      const subject = subjectOf(desk.store.get("lesson"), desk.store.get("teaching"));
      if (subject === null) {
        return;
      }
      pose.show(desk.store.get("draft").pose ?? subject.object.pose);
      const { form } = subject.of;
      sizes.hidden = form === null;
      movable.show(subject.of.movable);
      if (form !== null && form.kind !== shownKind) {
        shownKind = form.kind;
        const set = (changed: Form): void => withSubject(desk, (now) => reshape(desk, now, { form: changed }));
        fields = sizeFields(form.kind, set);
        size.replaceChildren(...fields.map(({ node }) => node));
      }
      if (form !== null) {
        fields.forEach((field) => field.show(form));
      }
    },
  };
}
