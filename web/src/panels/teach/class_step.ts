// The kind of a thing: one that is known, one that comes with the robot, or one made of a shape.

import { element } from "../../dom";
import type { Form } from "../../protocol";
import type { Desk } from "../../teach/desk";
import { plainName } from "../../teach/lesson";
import { firstForm, makeClass, putDown, takeClass } from "../../teach/things";
import { TEACH, words } from "../../text";
import { checkField, choiceField, CM, type Field, numberField, textField } from "../fields";
import { replaced } from "../pose_fields";
import { button, row, type StepView } from "./step";

export function classStep(desk: Desk): StepView {
  const known = element("div", { class: "choices" });
  const catalogue = element("div", { class: "choices" });
  const knownPart = element("section", {}, element("h4", {}, TEACH.known), known);
  const cataloguePart = element("section", {}, element("h4", {}, TEACH.catalogue), catalogue);
  const back = button(TEACH.back, () => desk.store.learn({ step: "overview" }));
  let shown = "";
  return {
    title: TEACH.classTitle,
    body: TEACH.classBody,
    nodes: [knownPart, maker(desk), cataloguePart, row(back)],
    show() {
      const teaching = desk.store.get("teaching");
      const used = new Set(teaching?.objects.map((object) => object.class));
      const names = {
        known: (teaching?.classes ?? []).map(({ name, description }) => ({ name, description, used: used.has(name) })),
        catalogue: teaching?.catalogue ?? [],
      };
      const text = JSON.stringify(names);
      if (text === shown) {
        return;
      }
      shown = text;
      knownPart.hidden = names.known.length === 0;
      cataloguePart.hidden = names.catalogue.length === 0;
      const choice = ({ name, description }: { name: string; description: string }, run: () => void): HTMLButtonElement => {
        const made = button(words(name), run);
        made.title = description;
        return made;
      };
      const forget = (name: string): HTMLButtonElement =>
        button(TEACH.forget, () => void desk.edits.ask({ kind: "remove_class", name }), {
          name: `${TEACH.forget} ${words(name)}`,
        });
      known.replaceChildren(
        ...names.known.flatMap((one) => {
          const choose = choice(one, () => void putDown(desk, one.name));
          // A kind of which there is a thing is needed.
          return one.used ? [choose] : [element("span", { class: "pair" }, choose, forget(one.name))];
        }),
      );
      catalogue.replaceChildren(...names.catalogue.map((one) => choice(one, () => void takeClass(desk, one.name))));
    },
  };
}

/** Makes a class of a shape. */
function maker(desk: Desk): HTMLElement {
  let name = "";
  let movable = true;
  let form = firstForm("cylinder");
  const sizes = element("div", { class: "three" });
  const make = button(TEACH.makeIt, () => void makeClass(desk, name, form, movable), { primary: true });
  const showSizes = (): void => {
    const fields = sizeFields(form.kind, (changed) => {
      form = changed;
      fields.forEach((field) => field.show(form));
    });
    fields.forEach((field) => field.show(form));
    sizes.replaceChildren(...fields.map(({ node }) => node));
  };
  const nameField = textField(TEACH.name, (text) => {
    name = plainName(text);
    make.disabled = name === "";
  });
  const shape = choiceField(TEACH.shape, [["cylinder", TEACH.cylinder], ["box", TEACH.box]], (kind) => {
    form = firstForm(kind === "box" ? "box" : "cylinder");
    showSizes();
  });
  const carry = checkField(TEACH.movable, (checked) => (movable = checked));
  carry.show(true);
  make.disabled = true;
  showSizes();
  return element(
    "section",
    {},
    element("h4", {}, TEACH.make),
    nameField.node,
    shape.node,
    sizes,
    carry.node,
    row(make),
  );
}

/** The sizes of a shape of this kind. */
export function sizeFields(kind: Form["kind"], set: (form: Form) => void): readonly Field<Form>[] {
  let now: Form | null = null;
  const size = (label: string, get: (form: Form) => number, changed: (form: Form, value: number) => Form): Field<Form> => {
    const field = numberField(
      label,
      CM,
      (value) => {
        if (now !== null) {
          set(changed(now, value));
        }
      },
      `${label}, cm`,
    );
    return {
      node: field.node,
      show(form) {
        now = form;
        field.show(get(form));
      },
    };
  };
  if (kind === "cylinder") {
    return [
      size(
        TEACH.diameter,
        (form) => (form.kind === "cylinder" ? form.diameter_m : 0),
        (form, diameter_m) => (form.kind === "cylinder" ? { ...form, diameter_m } : form),
      ),
      size(
        TEACH.height,
        (form) => (form.kind === "cylinder" ? form.height_m : 0),
        (form, height_m) => (form.kind === "cylinder" ? { ...form, height_m } : form),
      ),
    ];
  }
  return [TEACH.widthX, TEACH.widthY, TEACH.height].map((label, axis) =>
    size(
      label,
      (form) => (form.kind === "box" ? (form.size_m[axis] ?? 0) : 0),
      (form, value) => (form.kind === "box" ? { ...form, size_m: replaced(form.size_m, axis, value) } : form),
    ),
  );
}
