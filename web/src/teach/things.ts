// What a person does about things and their kinds: make or take a kind, put a thing down, move it, change its shape.

import type { EditOutcome, Form, Pose } from "../protocol";
import { type Desk, isAt, withSubject } from "./desk";
import type { Subject } from "./lesson";

/** Things are put down on this grid, metres. */
const PUT_DOWN_GRID_M = 0.05;

/** The shape that a new kind begins with. */
export function firstForm(kind: Form["kind"]): Form {
  return kind === "box" ? { kind, size_m: [0.2, 0.2, 0.2] } : { kind, diameter_m: 0.065, height_m: 0.2 };
}

/** Makes a class of a shape, and puts an object of it where the person looks. */
export async function makeClass(desk: Desk, name: string, form: Form, movable: boolean): Promise<void> {
  const lesson = desk.store.get("lesson");
  const outcome = await desk.edits.ask({ kind: "make_class", name, form, movable });
  if (isAccepted(outcome) && isAt(desk, lesson)) {
    await putDown(desk, name);
  }
}

/** Takes a class of the catalogue into the home, and puts an object of it where the person looks. */
export async function takeClass(desk: Desk, name: string): Promise<void> {
  const lesson = desk.store.get("lesson");
  const outcome = await desk.edits.ask({ kind: "take_class", name });
  if (isAccepted(outcome) && isAt(desk, lesson)) {
    await putDown(desk, name);
  }
}

/** Puts an object of a class where the person looks, and goes on with where it stands. */
export async function putDown(desk: Desk, name: string): Promise<void> {
  const lesson = desk.store.get("lesson");
  const [x, y] = desk.lookedAt();
  const rounded = (value: number): number => Math.round(value / PUT_DOWN_GRID_M) * PUT_DOWN_GRID_M;
  const outcome = await desk.edits.ask({
    kind: "add_object",
    class: name,
    pose: { position: [rounded(x), rounded(y), 0], orientation_xyzw: [0, 0, 0, 1] },
  });
  if (outcome.kind === "accepted" && isAt(desk, lesson)) {
    desk.store.learn({ step: "place", object: outcome.what });
  }
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

/** Puts a thing where numbers say. */
export function putAt(desk: Desk, pose: Pose): void {
  desk.store.drafted({ pose });
  void savePlace(desk);
}

export function putOnFloor(desk: Desk): void {
  withSubject(desk, ({ object: { pose } }) =>
    putAt(desk, { ...pose, position: [pose.position[0], pose.position[1], 0] }),
  );
}

export function takeOut(desk: Desk, object: string): void {
  void desk.edits.ask({ kind: "remove_object", name: object });
}

/** Gives the class of what is taught another shape, or says whether the robot can carry it. */
export function reshape(desk: Desk, { of }: Subject, changed: { form?: Form; movable?: boolean }): void {
  const form = changed.form ?? of.form;
  if (form !== null) {
    void desk.edits.ask({ kind: "reshape_class", name: of.name, form, movable: changed.movable ?? of.movable });
  }
}

export async function renameTo(desk: Desk, object: string, to: string): Promise<void> {
  const outcome = await desk.edits.ask({ kind: "rename_object", name: object, to });
  // The thing of the old name is gone, and with it the step that was about it.
  if (outcome.kind === "accepted" && desk.store.get("lesson").step === "overview") {
    desk.store.learn({ step: "place", object: outcome.what });
  }
}

function isAccepted(outcome: EditOutcome): boolean {
  return outcome.kind === "accepted";
}
