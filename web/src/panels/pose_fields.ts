// A pose as six numbers, for who has no mouse or wants it exact.

import { element } from "../dom";
import { orientationFromRpy, rpyOf } from "../frames";
import type { Pose } from "../protocol";
import { TEACH } from "../text";
import { CM, DEGREES, type Field, numberField } from "./fields";

export function poseFields(changed: (pose: Pose) => void): Field<Pose> {
  let pose: Pose = { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] };
  const at = TEACH.axes.map((axis, index) =>
    numberField(axis, CM, (value) => {
      changed({ ...pose, position: replaced(pose.position, index, value) });
    }),
  );
  const turned = TEACH.turns.map((turn, index) =>
    numberField(turn, DEGREES, (value) => {
      const rpy = replaced(rpyOf(pose.orientation_xyzw), index, value);
      changed({ ...pose, orientation_xyzw: orientationFromRpy(rpy) });
    }),
  );
  const group = (label: string, fields: readonly Field<number>[]): HTMLElement =>
    element("fieldset", { class: "three" }, element("legend", {}, label), ...fields.map(({ node }) => node));
  return {
    node: element("div", {}, group(TEACH.position, at), group(TEACH.orientation, turned)),
    show(value) {
      pose = value;
      at.forEach((field, index) => field.show(value.position[index] ?? 0));
      const rpy = rpyOf(value.orientation_xyzw);
      turned.forEach((field, index) => field.show(rpy[index] ?? 0));
    },
  };
}

/** Three numbers with one of them replaced. */
export function replaced(three: readonly [number, number, number], index: number, value: number): [number, number, number] {
  const [x, y, z] = three;
  return [index === 0 ? value : x, index === 1 ? value : y, index === 2 ? value : z];
}
