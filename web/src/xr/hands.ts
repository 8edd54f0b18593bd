// What is seen of the hands that point: a line to what they point at, and in VR the hand or controller itself.

import {
  BufferGeometry,
  CylinderGeometry,
  Float32BufferAttribute,
  type Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  type Object3D,
  SphereGeometry,
} from "three";

const JOINT_RADIUS_M = 0.008;
const CURSOR_RADIUS_M = 0.008;

/** The line of a ray, with a dot where it ends; below the ray's own group, along its -z. */
export class Beam {
  readonly parts: readonly Object3D[];
  private readonly line: Line<BufferGeometry, LineBasicMaterial>;
  private readonly dot: Mesh<SphereGeometry, MeshBasicMaterial>;

  constructor(colour: number) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute([0, 0, 0, 0, 0, -1], 3));
    this.line = new Line(geometry, new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.8, fog: false }));
    this.dot = new Mesh(new SphereGeometry(CURSOR_RADIUS_M, 12, 8), new MeshBasicMaterial({ color: colour, fog: false }));
    this.line.renderOrder = 4;
    this.dot.renderOrder = 4;
    this.parts = [this.line, this.dot];
  }

  /** Reaches so far, metres; brighter while it holds something. Allocates nothing. */
  reach(distance: number, holds: boolean): void {
    this.line.scale.z = distance;
    this.line.material.opacity = holds ? 1 : 0.6;
    this.dot.position.z = -distance;
    this.dot.scale.setScalar((holds ? 1.6 : 1) * Math.max(1, distance));
  }

  dispose(): void {
    this.line.geometry.dispose();
    this.line.material.dispose();
    this.dot.geometry.dispose();
    this.dot.material.dispose();
  }
}

const material = new MeshLambertMaterial({ color: 0x8a97a3 });
const joint = new SphereGeometry(JOINT_RADIUS_M, 10, 6);
const handle = new CylinderGeometry(0.009, 0.014, 0.1, 16).rotateX(Math.PI / 2).translate(0, 0, 0.05);

/** What a controller looks like: below the group of its ray. */
export function controllerHandle(): Object3D {
  return new Mesh(handle, material);
}

/** Gives each joint of a hand a knuckle, as joints come to be known. */
export function knuckles(hand: Group): void {
  for (const one of hand.children) {
    if (one.children.length === 0) {
      one.add(new Mesh(joint, material));
    }
  }
}
