// The model of a class, its joints where they are asked to be.

import { Box3, Group, type Material, Matrix4, Mesh, type Object3D, Quaternion, Vector3 } from "three";

import { place } from "../frames";
import type { ClassJoint, ClassPart, TaughtClass } from "../protocol";
import type { Size } from "../teach/lesson";
import { isShared, shown } from "./geometries";

const joint = new Matrix4();
const back = new Matrix4();
const turn = new Quaternion();
const axis = new Vector3();

/** A class's shapes, all of one material. */
export class ClassModel {
  readonly root = new Group();
  private readonly parts: { readonly group: Group; readonly joints: readonly ClassJoint[] }[];

  constructor(of: Pick<TaughtClass, "parts" | "joints">, material: Material) {
    this.parts = of.parts.map((part) => ({ group: partGroup(part, material), joints: jointsOf(part, of.joints) }));
    for (const { group } of this.parts) {
      group.matrixAutoUpdate = false;
      this.root.add(group);
    }
  }

  /** Puts a joint at a position, and all others at zero. */
  pose(name: string, position: number): void {
    for (const { group, joints } of this.parts) {
      group.matrix.identity();
      for (const moving of joints) {
        if (moving.name === name) {
          group.matrix.multiply(motionOf(moving, position, joint));
        }
      }
      group.matrixWorldNeedsUpdate = true;
    }
  }

  /** What a joint moves. */
  movedBy(name: string): Object3D[] {
    return this.parts.filter(({ joints }) => joints.some((joint) => joint.name === name)).map(({ group }) => group);
  }

  dispose(): void {
    this.root.removeFromParent();
    this.root.traverse((node) => {
      if (node instanceof Mesh && !isShared(node.geometry)) {
        node.geometry.dispose();
      }
    });
  }
}

/** How far a class reaches with all joints at zero. */
export function sizeOf(of: Pick<TaughtClass, "parts">): Size {
  const root = new Group();
  for (const part of of.parts) {
    root.add(partGroup(part, null));
  }
  root.updateMatrixWorld(true);
  const box = new Box3().setFromObject(root);
  if (box.isEmpty()) {
    return { radius: 0.05, height: 0.1 };
  }
  const size = box.getSize(new Vector3());
  return { radius: 0.5 * Math.min(size.x, size.y), height: box.max.z };
}

function partGroup(part: ClassPart, material: Material | null): Group {
  const group = new Group();
  for (const shape of part.shapes) {
    const what = shown(shape.geometry);
    if (what !== null) {
      const mesh = material === null ? new Mesh(what.geometry) : new Mesh(what.geometry, material);
      mesh.scale.copy(what.scale);
      place(mesh, shape.pose);
      group.add(mesh);
    }
  }
  return group;
}

function jointsOf(part: ClassPart, joints: readonly ClassJoint[]): ClassJoint[] {
  return part.joints.flatMap((name) => joints.find((other) => other.name === name) ?? []);
}

/** Motion of a joint's link in Λ from zero to a position. */
function motionOf(moving: ClassJoint, position: number, out: Matrix4): Matrix4 {
  axis.set(...moving.axis).normalize();
  if (moving.kind === "prismatic") {
    axis.multiplyScalar(position);
    return out.makeTranslation(axis.x, axis.y, axis.z);
  }
  const [x, y, z] = moving.origin;
  out.makeRotationFromQuaternion(turn.setFromAxisAngle(axis, position));
  out.premultiply(back.makeTranslation(x, y, z));
  return out.multiply(back.makeTranslation(-x, -y, -z));
}
