// Frames of the wire and of the renderer, in one place.
//
// On the wire the world is that of REP-103: x forward, y left, z up, metres, quaternions xyzw.
// three.js and WebXR have y up and look along -z. Everything of the wire is therefore put, as it
// is, below one group that is turned by Z_UP_TO_Y_UP; nothing else converts.

import { Euler, type Object3D, Quaternion, Vector3 } from "three";

import type { Pose, PosePlanar } from "./protocol";

/** Turns the wire's world (z up) into the renderer's (y up): a quarter turn about x. */
export const Z_UP_TO_Y_UP: Readonly<Quaternion> = new Quaternion(
  -Math.SQRT1_2,
  0,
  0,
  Math.SQRT1_2,
);

/** A point of the wire's world in the renderer's. */
export function yUpFromZUp(x: number, y: number, z: number, out: Vector3): Vector3 {
  return out.set(x, z, -y);
}

/** A point of the renderer's world in the wire's. */
export function zUpFromYUp(x: number, y: number, z: number, out: Vector3): Vector3 {
  return out.set(x, -z, y);
}

/** Puts an object, below the turned group, at a pose of the wire. Allocates nothing. */
export function place(object: Object3D, pose: Pose): void {
  const [x, y, z] = pose.position;
  const [qx, qy, qz, qw] = pose.orientation_xyzw;
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw).normalize();
}

/** Puts an object at a pose on the floor. Allocates nothing. */
export function placePlanar(object: Object3D, pose: PosePlanar): void {
  object.position.set(pose.x, pose.y, object.position.z);
  object.quaternion.set(0, 0, Math.sin(pose.yaw / 2), Math.cos(pose.yaw / 2));
}

/** Whether all numbers are there: JSON turns a NaN into null. */
export function isFinitePose(pose: Pose): boolean {
  return pose.position.every(Number.isFinite) && pose.orientation_xyzw.every(Number.isFinite);
}

/** The heading of a quaternion about z, in radians. */
export function yawOf([x, y, z, w]: Pose["orientation_xyzw"]): number {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** Roll, pitch and yaw about the fixed axes x, y and z (REP-103), in radians. */
export function rpyOf(orientation: Pose["orientation_xyzw"]): [number, number, number] {
  const euler = new Euler().setFromQuaternion(new Quaternion(...orientation).normalize(), "ZYX");
  return [euler.x, euler.y, euler.z];
}

/** The orientation of these roll, pitch and yaw. */
export function orientationFromRpy([roll, pitch, yaw]: readonly [number, number, number]): Pose["orientation_xyzw"] {
  const turned = new Quaternion().setFromEuler(new Euler(roll, pitch, yaw, "ZYX"));
  return [turned.x, turned.y, turned.z, turned.w];
}

/** The pose at which an object below the turned group stands. */
export function poseOf(object: Object3D): Pose {
  const { position, quaternion } = object;
  return {
    position: [position.x, position.y, position.z],
    orientation_xyzw: [quaternion.x, quaternion.y, quaternion.z, quaternion.w],
  };
}

/** A from c, from a from b and b from c. */
export function composed(aFromB: Pose, bFromC: Pose): Pose {
  const turn = new Quaternion(...aFromB.orientation_xyzw).normalize();
  const at = new Vector3(...bFromC.position).applyQuaternion(turn).add(new Vector3(...aFromB.position));
  const whole = turn.multiply(new Quaternion(...bFromC.orientation_xyzw)).normalize();
  return { position: [at.x, at.y, at.z], orientation_xyzw: [whole.x, whole.y, whole.z, whole.w] };
}

export const IDENTITY: Pose = { position: [0, 0, 0], orientation_xyzw: [0, 0, 0, 1] };

/** B from a, from a from b. */
export function inverted(aFromB: Pose): Pose {
  const [x, y, z, w] = aFromB.orientation_xyzw;
  const [px, py, pz] = aFromB.position;
  return composed(
    { position: [0, 0, 0], orientation_xyzw: [-x, -y, -z, w] },
    { position: [-px, -py, -pz], orientation_xyzw: [0, 0, 0, 1] },
  );
}
