// What a hand does with what it has taken, from the moment it takes it until it lets go. Hands are given as poses of their
// rays in XR; what is dragged is changed at the desk (`teach/drag.ts`), as it is by a mouse.

import { Quaternion, Vector3 } from "three";

import { composed, inverted } from "../frames";
import type { ClassJoint, Pose } from "../protocol";
import { type Desk, withSubject } from "../teach/desk";
import { changeJoint } from "../teach/doing";
import { dragTo, heldOf, jointDragged, jointTravel, uprightTurn, worldFromHeld } from "../teach/drag";
import { savePlace } from "../teach/things";
import { carried, type MapFromXr, mapPoint, mapPose, type Point } from "./map_from_xr";

export interface Drag {
  /** The hand is here now; the other hand helps if it holds, too. */
  move(xrFromRay: Pose, other: Point | null): void;
  end(): void;
}

/** A point on a ray, so many metres along it. */
export function alongRay(xrFromRay: Pose, distance: number): [number, number, number] {
  return composed(xrFromRay, { position: [0, 0, -distance], orientation_xyzw: [0, 0, 0, 1] }).position;
}

/** Heading of a line on the floor of the map, radians. */
function headingOf(from: Point, to: Point): number {
  return Math.atan2(to[1] - from[1], to[0] - from[0]);
}

function times(turn: Quaternion, orientation: Pose["orientation_xyzw"]): Pose["orientation_xyzw"] {
  const whole = turn.clone().multiply(new Quaternion(...orientation));
  return [whole.x, whole.y, whole.z, whole.w];
}

/** From one orientation to another, in the frame in which both are given. */
function turnBetween(from: Pose, to: Pose): Quaternion {
  return new Quaternion(...to.orientation_xyzw).multiply(new Quaternion(...from.orientation_xyzw).invert());
}

/** Drags what the step is about. It goes where the hand's ray carries it, or turns with the hand; two hands do both. */
export function thingDrag(desk: Desk, mapFromXr: MapFromXr, xrFromRay: Pose): Drag | null {
  const { store } = desk;
  const lesson = store.get("lesson");
  const held = heldOf(lesson, store.get("draft"), store.get("teaching"));
  if (held === null) {
    return null;
  }
  const start = worldFromHeld(held);
  const rayThen = mapPose(mapFromXr, xrFromRay);
  const rayFromHeld = composed(inverted(rayThen), start);
  let headingThen: number | null = null;
  return {
    move(xrFromRayNow, other) {
      const ray = mapPose(mapFromXr, xrFromRayNow);
      const isTurning = store.get("hand").mode === "turn";
      const position = isTurning ? start.position : composed(ray, rayFromHeld).position;
      let turn = new Quaternion();
      if (other !== null) {
        const heading = headingOf(ray.position, mapPoint(mapFromXr, other));
        headingThen ??= heading;
        turn.setFromAxisAngle(new Vector3(0, 0, 1), heading - headingThen);
      } else if (isTurning) {
        turn = turnBetween(rayThen, ray);
        // Things stand as they stood; hands are held in any way.
        turn = lesson.step === "place" ? uprightTurn(turn) : turn;
      }
      if (store.get("lesson") === lesson) {
        dragTo(store, start, { position, orientation_xyzw: times(turn, start.orientation_xyzw) });
      }
    },
    end() {
      void savePlace(desk);
    },
  };
}

/** Drags a part of a thing along its joint to where an action begins or ends. `grabbed` is the point taken, in XR. */
export function jointDrag(
  desk: Desk,
  mapFromXr: MapFromXr,
  xrFromRay: Pose,
  grabbed: Point,
  end: "initiation" | "termination",
): Drag | null {
  const { store } = desk;
  let made: Drag | null = null;
  withSubject(desk, ({ object, of }) => {
    const motion = store.get("draft").action?.motion;
    const joint: ClassJoint | undefined = of.joints.find(({ name }) => motion?.kind === "joint" && name === motion.joint);
    if (motion?.kind !== "joint" || joint === undefined) {
      return;
    }
    const lesson = store.get("lesson");
    const start = (end === "initiation" ? motion.initiation : motion.termination) ?? joint.range[0];
    const objectFromMap = inverted(object.pose);
    const inObject = (xr: Point): Point => pointOf(objectFromMap, mapPoint(mapFromXr, xr));
    const inRay = pointOf(inverted(xrFromRay), grabbed);
    const from = inObject(grabbed);
    made = {
      move(xrFromRayNow) {
        if (store.get("lesson") === lesson) {
          const travel = jointTravel(joint, from, inObject(pointOf(xrFromRayNow, inRay)));
          changeJoint(desk, of, { [end]: jointDragged(joint, start, travel, store.get("hand")) });
        }
      },
      end() {},
    };
  });
  return made;
}

function pointOf(aFromB: Pose, inB: Point): [number, number, number] {
  return composed(aFromB, { position: [...inB], orientation_xyzw: [0, 0, 0, 1] }).position;
}

/** Drags the whole world by a point of XR, along the floor and about the upright. */
export function worldDrag(
  start: MapFromXr,
  xrFromRay: Pose,
  grabbed: Point,
  speed: () => number,
  show: (mapFromXr: MapFromXr) => void,
  done: (mapFromXr: MapFromXr) => void,
): Drag {
  const inRay = pointOf(inverted(xrFromRay), grabbed);
  const rayThen = mapPose(start, xrFromRay);
  let now = start;
  return {
    move(xrFromRayNow) {
      const share = speed();
      const [x, , z] = pointOf(xrFromRayNow, inRay);
      const upright = uprightTurn(turnBetween(rayThen, mapPose(start, xrFromRayNow)));
      const turn = 2 * Math.atan2(upright.z, upright.w);
      const to: Point = [grabbed[0] + share * (x - grabbed[0]), grabbed[1], grabbed[2] + share * (z - grabbed[2])];
      now = carried(start, grabbed, to, share * (turn > Math.PI ? turn - 2 * Math.PI : turn));
      show(now);
    },
    end() {
      done(now);
    },
  };
}

/** Drags something that stands in XR itself, such as a panel. */
export function carriedDrag(xrFromRay: Pose, xrFromIt: Pose, show: (xrFromIt: Pose) => void): Drag {
  const rayFromIt = composed(inverted(xrFromRay), xrFromIt);
  return {
    move(xrFromRayNow) {
      show(composed(xrFromRayNow, rayFromIt));
    },
    end() {},
  };
}
