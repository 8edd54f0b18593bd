// What each step of teaching says in a headset, and which buttons it has. What they do is what they do on the page.

import { rpyOf } from "../frames";
import { regionColour } from "../palette";
import type { Action, ClassJoint, Form, Grasp } from "../protocol";
import { type Desk, goTo } from "../teach/desk";
import {
  canSaveAction,
  changeAction,
  changeJoint,
  chooseJoint,
  choosePut,
  forgetAction,
  newAction,
  openAction,
  saveAction,
  targets,
} from "../teach/doing";
import { heldOf } from "../teach/drag";
import { beginGrasp, canSaveGrasp, changeGrasp, forgetGrasp, openGrasp, saveGrasp } from "../teach/holding";
import { freeName, type Lesson, subjectOf, type Subject } from "../teach/lesson";
import { firstForm, makeClass, putDown, putOnFloor, renameTo, reshape, takeClass, takeOut } from "../teach/things";
import { cmText, degreesText, HEADSET, poseText, TEACH, words } from "../text";
import type { Writing } from "./keyboard";
import { EMPTY_MENU, type Menu, type MenuButton } from "./menu";

/** Lets a person write a name. */
export type Write = (writing: Writing) => void;

/** A step's own part of the menu. */
export function stepMenu(desk: Desk, write: Write): Menu {
  const lesson = desk.store.get("lesson");
  if (lesson.step === "overview") {
    return overview(desk);
  }
  if (lesson.step === "class") {
    return kinds(desk);
  }
  const subject = subjectOf(lesson, desk.store.get("teaching"));
  if (subject === null) {
    return EMPTY_MENU;
  }
  switch (lesson.step) {
    case "place":
      return place(desk, subject, write);
    case "grasps":
      return grasps(desk, subject);
    case "grasp":
      return grasp(desk, subject, lesson, write);
    case "actions":
      return actions(desk, subject);
    case "action":
      return action(desk, subject, lesson, write);
  }
}

function overview(desk: Desk): Menu {
  const objects = desk.store.get("teaching")?.objects ?? [];
  return {
    ...EMPTY_MENU,
    title: TEACH.overviewTitle,
    body: objects.length === 0 ? TEACH.overviewEmpty : TEACH.overview,
    list: objects.map(({ name, colour_index }) => ({
      label: words(name),
      swatch: regionColour(colour_index),
      run: () => desk.store.learn({ step: "place", object: name }),
    })),
    rows: [[{ label: TEACH.teachNew, isPrimary: true, run: () => desk.store.learn({ step: "class" }) }]],
  };
}

function kinds(desk: Desk): Menu {
  const teaching = desk.store.get("teaching");
  const known = (teaching?.classes ?? []).map(({ name }) => ({ label: words(name), run: () => void putDown(desk, name) }));
  const catalogue = (teaching?.catalogue ?? []).map(({ name }) => ({
    label: words(name),
    run: () => void takeClass(desk, name),
  }));
  const taken = [...(teaching?.classes ?? []), ...(teaching?.catalogue ?? [])].map(({ name }) => name);
  const made = (kind: Form["kind"], label: string): MenuButton => ({
    label: `${TEACH.makeIt}: ${label.toLowerCase()}`,
    run: () => void makeClass(desk, freeName(kind, taken), firstForm(kind), kind === "cylinder"),
  });
  return {
    ...EMPTY_MENU,
    title: TEACH.classTitle,
    body: TEACH.classBody,
    list: [...known, ...catalogue],
    rows: [
      [made("cylinder", TEACH.cylinder), made("box", TEACH.box)],
      [{ label: TEACH.back, run: () => desk.store.learn({ step: "overview" }) }],
    ],
  };
}

function place(desk: Desk, subject: Subject, write: Write): Menu {
  const { object, of } = subject;
  const { form } = of;
  const rename: MenuButton = {
    label: TEACH.rename,
    run: () => write({ what: TEACH.name, text: words(object.name), finish: (name) => void renameTo(desk, object.name, name) }),
  };
  const carry: MenuButton[] =
    form === null
      ? []
      : [{ label: HEADSET.carried, isPressed: of.movable, run: () => reshape(desk, subject, { movable: !of.movable }) }];
  return {
    ...EMPTY_MENU,
    title: TEACH.placeTitle(object.name),
    body: HEADSET.placeBody,
    values: [held(desk), ...(form === null ? [] : [formText(form)])].join(" · "),
    rows: [
      form === null ? [] : sizes(desk, subject, form),
      [{ label: TEACH.onFloor, run: () => putOnFloor(desk) }, ...carry],
      [rename, { label: TEACH.remove, run: () => takeOut(desk, object.name) }],
      [
        { label: TEACH.back, run: () => desk.store.learn({ step: "overview" }) },
        { label: TEACH.next, isPrimary: true, run: () => goTo(desk, "grasps") },
      ],
    ],
  };
}

function grasps(desk: Desk, subject: Subject): Menu {
  const { of } = subject;
  return {
    ...EMPTY_MENU,
    title: TEACH.graspsTitle(of.name),
    body: of.grasps.length === 0 ? `${TEACH.graspsBody} ${TEACH.graspsEmpty}` : TEACH.graspsBody,
    list: of.grasps.map((one) => ({ label: words(one.name), run: () => openGrasp(desk, one) })),
    rows: [
      [{ label: TEACH.addGrasp, run: () => openGrasp(desk, null) }],
      [
        { label: TEACH.back, run: () => goTo(desk, "place") },
        { label: TEACH.next, isPrimary: true, run: () => goTo(desk, "actions") },
      ],
    ],
  };
}

function grasp(desk: Desk, subject: Subject, lesson: Extract<Lesson, { name: string }>, write: Write): Menu {
  const draft: Grasp | null = desk.store.get("draft").grasp;
  if (draft === null) {
    return EMPTY_MENU;
  }
  const widest = desk.store.get("teaching")?.aperture_max_m ?? 0;
  const open = (step: number) => (): void =>
    changeGrasp(desk, { aperture_m: bounded(draft.aperture_m + step, 0, widest) });
  const step = stepOf(desk);
  return {
    ...EMPTY_MENU,
    title: TEACH.graspTitle(subject.of.name),
    body: HEADSET.graspBody,
    values: `${words(draft.name)} · ${held(desk)} · ${HEADSET.valueOf(HEADSET.opening, cmText(draft.aperture_m))}`,
    rows: [
      [
        { label: TEACH.fromSide, run: () => beginGrasp(desk, "side") },
        { label: TEACH.fromAbove, run: () => beginGrasp(desk, "above") },
      ],
      [
        { label: HEADSET.less(HEADSET.opening), run: open(-step) },
        { label: HEADSET.more(HEADSET.opening), run: open(step) },
        {
          label: HEADSET.symmetric,
          isPressed: draft.yaw_symmetric,
          run: () => changeGrasp(desk, { yaw_symmetric: !draft.yaw_symmetric }),
        },
      ],
      [...naming(lesson, draft.name, write, (name) => changeGrasp(desk, { name })), ...forgetting(lesson, () => {
        forgetGrasp(desk, subject, lesson.name);
      })],
      [
        { label: TEACH.cancel, run: () => goTo(desk, "grasps") },
        { label: TEACH.save, isPrimary: true, isDisabled: !canSaveGrasp(desk), run: () => void saveGrasp(desk, subject) },
      ],
    ],
  };
}

function actions(desk: Desk, subject: Subject): Menu {
  const { of } = subject;
  const into: MenuButton = {
    label: TEACH.addPutInto,
    isDisabled: targets(desk, of).length === 0,
    run: () => newAction(desk, "put_into"),
  };
  const joint: MenuButton = { label: TEACH.addJoint, run: () => newAction(desk, "joint") };
  return {
    ...EMPTY_MENU,
    title: TEACH.actionsTitle(of.name),
    body: of.movable && into.isDisabled === true ? TEACH.noContainer : TEACH.actionsBody,
    values: of.actions.length === 0 ? TEACH.actionsEmpty : "",
    list: of.actions.map((one) => ({ label: words(one.name), run: () => openAction(desk, subject, one) })),
    rows: [
      [...(of.movable ? [into] : []), ...(of.joints.length > 0 ? [joint] : [])],
      [
        { label: TEACH.back, run: () => goTo(desk, "grasps") },
        { label: TEACH.finish, isPrimary: true, run: () => desk.store.learn({ step: "overview" }) },
      ],
    ],
  };
}

function action(desk: Desk, subject: Subject, lesson: Extract<Lesson, { name: string }>, write: Write): Menu {
  const draft: Action | null = desk.store.get("draft").action;
  if (draft === null) {
    return EMPTY_MENU;
  }
  const { of } = subject;
  const isJoint = draft.motion.kind === "joint";
  const withGrasp = next([null, ...of.grasps.map(({ name }) => name)], draft.grasp);
  return {
    ...EMPTY_MENU,
    title: TEACH.actionTitle(of.name),
    body: `${isJoint ? HEADSET.jointBody : HEADSET.putIntoBody} ${HEADSET.distances}`,
    values: `${draft.name === "" ? "?" : words(draft.name)} · ${motionText(desk, subject, draft)}`,
    rows: [
      ...(isJoint ? jointRows(desk, subject, draft, write) : intoRows(desk, subject, draft)),
      [
        {
          label: HEADSET.valueOf(`${TEACH.withGrasp}:`, draft.grasp === null ? TEACH.anyGrasp : words(draft.grasp)),
          run: () => changeAction(desk, { grasp: withGrasp }),
        },
        ...naming(lesson, draft.name, write, (name) => changeAction(desk, { name })),
        ...forgetting(lesson, () => {
          forgetAction(desk, subject, lesson.name);
        }),
      ],
      [
        { label: TEACH.cancel, run: () => goTo(desk, "actions") },
        { label: TEACH.save, isPrimary: true, isDisabled: !canSaveAction(desk), run: () => void saveAction(desk, subject) },
      ],
    ],
  };
}

function intoRows(desk: Desk, subject: Subject, { motion }: Action): MenuButton[][] {
  if (motion.kind !== "put_into") {
    return [];
  }
  const into = next(targets(desk, subject.of).map(({ name }) => name), motion.class);
  const label = HEADSET.valueOf(`${TEACH.into}:`, words(motion.class));
  return [[{ label, run: () => choosePut(desk, subject, into ?? motion.class) }]];
}

function jointRows(desk: Desk, { of }: Subject, { motion }: Action, write: Write): MenuButton[][] {
  const joint = motion.kind === "joint" ? of.joints.find(({ name }) => name === motion.joint) : undefined;
  if (motion.kind !== "joint" || joint === undefined) {
    return [];
  }
  const part = next(of.joints.map(({ name }) => name), joint.name) ?? joint.name;
  const isHeld = motion.contact === "grasp";
  return [
    of.joints.length > 1
      ? [{ label: HEADSET.valueOf(`${TEACH.part}:`, words(joint.name)), run: () => chooseJoint(desk, of, part) }]
      : [],
    [
      {
        label: HEADSET.valueOf(TEACH.contact, isHeld ? TEACH.grasps : TEACH.pushes),
        run: () => changeJoint(desk, of, { contact: isHeld ? "push" : "grasp" }),
      },
      {
        label: HEADSET.valueOf(`${TEACH.effect}:`, motion.effect === "" ? "?" : words(motion.effect)),
        run: () =>
          write({ what: TEACH.effect, text: words(motion.effect), finish: (effect) => changeJoint(desk, of, { effect }) }),
      },
    ],
  ];
}

/** A name is what a thing is changed by: only a new one is named. */
function naming(lesson: { name: string }, text: string, write: Write, finish: (name: string) => void): MenuButton[] {
  const run = (): void => write({ what: TEACH.name, text: words(text), finish });
  return lesson.name === "" ? [{ label: HEADSET.rename, run }] : [];
}

function forgetting(lesson: { name: string }, run: () => void): MenuButton[] {
  return lesson.name === "" ? [] : [{ label: HEADSET.forget(words(lesson.name)), run }];
}

/** The pose of what is held, in numbers. */
function held(desk: Desk): string {
  const what = heldOf(desk.store.get("lesson"), desk.store.get("draft"), desk.store.get("teaching"));
  if (what === null) {
    return "";
  }
  const { position, orientation_xyzw } = what.baseFromHeld;
  return poseText(position, rpyOf(orientation_xyzw)[2]);
}

function motionText(desk: Desk, { of }: Subject, { motion }: Action): string {
  if (motion.kind === "put_into") {
    return held(desk);
  }
  const joint = of.joints.find(({ name }) => name === motion.joint);
  const text = (position: number): string => jointText(joint, position);
  return [
    HEADSET.valueOf(HEADSET.begins, text(motion.initiation ?? joint?.range[0] ?? 0)),
    HEADSET.valueOf(HEADSET.ends, text(motion.termination)),
  ].join(", ");
}

function jointText(joint: ClassJoint | undefined, position: number): string {
  return joint?.kind === "prismatic" ? cmText(position) : degreesText(position);
}

function formText(form: Form): string {
  return sizesOf(form)
    .map(({ label, value }) => HEADSET.valueOf(label, cmText(value)))
    .join(", ");
}

interface Size {
  readonly label: string;
  readonly value: number;
  readonly changed: (value: number) => Form;
}

function sizesOf(form: Form): readonly Size[] {
  if (form.kind === "cylinder") {
    return [
      { label: TEACH.diameter, value: form.diameter_m, changed: (diameter_m) => ({ ...form, diameter_m }) },
      { label: TEACH.height, value: form.height_m, changed: (height_m) => ({ ...form, height_m }) },
    ];
  }
  const [x, y, z] = form.size_m;
  return [
    { label: HEADSET.length, value: x, changed: (value) => ({ ...form, size_m: [value, y, z] }) },
    { label: HEADSET.width, value: y, changed: (value) => ({ ...form, size_m: [x, value, z] }) },
    { label: TEACH.height, value: z, changed: (value) => ({ ...form, size_m: [x, y, value] }) },
  ];
}

function sizes(desk: Desk, subject: Subject, form: Form): MenuButton[] {
  const step = stepOf(desk);
  return sizesOf(form).flatMap(({ label, value, changed }) => {
    const by = (change: number) => (): void =>
      reshape(desk, subject, { form: changed(bounded(value + change, step, Number.POSITIVE_INFINITY)) });
    return [
      { label: HEADSET.less(label), run: by(-step) },
      { label: HEADSET.more(label), run: by(step) },
    ];
  });
}

/** How much a button changes a length, metres: less in fine work. */
function stepOf(desk: Desk): number {
  return desk.store.get("hand").speed < 1 ? 0.001 : 0.01;
}

/** To a tenth of a millimetre, so that ten steps are ten steps. */
function bounded(value: number, low: number, high: number): number {
  return Math.min(Math.max(Math.round(value * 1e4) / 1e4, low), high);
}

/** What comes after a value, round and round. */
function next<T>(all: readonly T[], now: T): T | null {
  return all[(all.indexOf(now) + 1) % all.length] ?? null;
}
