// Where a thing stands (Γ), and how large it is if it is made of a shape.

import { element } from "../../dom";
import type { Form, Pose } from "../../protocol";
import { plainName, subjectOf } from "../../teach/lesson";
import { TEACH } from "../../text";
import { checkField, type Field, textField } from "../fields";
import { poseFields } from "../pose_fields";
import { sizeFields } from "./class_step";
import { dragTools } from "./drag_tools";
import { button, type Desk, goTo, isAt, row, type StepView, withSubject } from "./step";

export function placeStep(desk: Desk, object: string): StepView {
  const pose = poseFields((changed) => {
    desk.store.drafted({ pose: changed });
    void savePlace(desk);
  });
  const floor = button(TEACH.onFloor, () =>
    withSubject(desk, ({ object: { pose: now } }) => {
      desk.store.drafted({ pose: { ...now, position: [now.position[0], now.position[1], 0] } });
      void savePlace(desk);
    }),
  );
  const remove = button(TEACH.remove, () => void desk.edits.ask({ kind: "remove_object", name: object }));
  let written = object;
  const name = textField(TEACH.name, (text) => (written = plainName(text)));
  name.show(object);
  const rename = row(name.node, button(TEACH.rename, () => void renameTo(desk, object, written)));
  const size = element("div", { class: "three" });
  const movable = checkField(TEACH.movable, (carried) =>
    withSubject(desk, ({ of }) => {
      if (of.form !== null) {
        reshape(desk, of.name, of.form, carried);
      }
    }),
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
      const { form, name } = subject.of;
      sizes.hidden = form === null;
      movable.show(subject.of.movable);
      if (form !== null && form.kind !== shownKind) {
        shownKind = form.kind;
        const set = (changed: Form): void => withSubject(desk, ({ of }) => reshape(desk, name, changed, of.movable));
        fields = sizeFields(form.kind, set);
        size.replaceChildren(...fields.map(({ node }) => node));
      }
      if (form !== null) {
        fields.forEach((field) => field.show(form));
      }
    },
  };
}

async function renameTo(desk: Desk, object: string, to: string): Promise<void> {
  const outcome = await desk.edits.ask({ kind: "rename_object", name: object, to });
  // The thing of the old name is gone, and with it the step that was about it.
  if (outcome.kind === "accepted" && desk.store.get("lesson").step === "overview") {
    desk.store.learn({ step: "place", object: outcome.what });
  }
}

function reshape(desk: Desk, name: string, form: Form, movable: boolean): void {
  void desk.edits.ask({ kind: "reshape_class", name, form, movable });
}

/** Saves where a thing was dragged to; until the answer is there it is shown where it was let go. */
export async function savePlace(desk: Desk): Promise<void> {
  const lesson = desk.store.get("lesson");
  const pose: Pose | null = desk.store.get("draft").pose;
  if (lesson.step !== "place" || pose === null) {
    return;
  }
  await desk.edits.ask({ kind: "move_object", name: lesson.object, pose });
  // Dragged again meanwhile, it is saved again.
  if (isAt(desk, lesson) && desk.store.get("draft").pose === pose) {
    desk.store.drafted({ pose: null });
  }
}

