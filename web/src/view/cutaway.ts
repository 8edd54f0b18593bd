// Walls that stand between the camera and what it looks at are lowered to a kerb, so that one can
// look into a home as into a doll's house.
//
// A wall is an upright thin box taller than a person's shoulder, which no message has to say. It
// stands in the way when camera and target lie on different sides of its plane.

import { type Mesh, Vector3 } from "three";

import type { Geometry } from "../protocol";

/** Lowest height of a thin box that counts as a wall. */
const HEIGHT_MIN_M = 1.5;
const THICKNESS_MAX_M = 0.3;
/** What is left of a lowered wall. */
const KERB_M = 0.08;
/** A wall that begins above this is a lintel, of which nothing is left. */
const LINTEL_BOTTOM_M = 1.2;
/** Part of the way that a wall moves in a second: quick, but to be followed by the eye. */
const RATE_PER_SEC = 9;
/** Distance from the wall's plane within which it stays as it is, so that it does not flutter. */
const DEADBAND_M = 0.05;

interface Wall {
  readonly mesh: Mesh;
  readonly vertical: "x" | "y" | "z";
  readonly thin: "x" | "y" | "z";
  /** Scale along the vertical when the wall is up, which is its height. */
  readonly height: number;
  readonly kerb: number;
  /** Unit vector from the centre to the foot, in the body's frame. */
  readonly down: Vector3;
  readonly centre: Vector3;
  /** 0 up, 1 lowered. */
  lowered: number;
  inTheWay: boolean;
}

const AXES = ["x", "y", "z"] as const;

export class Cutaway {
  private readonly walls = new Map<Mesh, Wall>();
  private readonly centre = new Vector3();
  private readonly normal = new Vector3();
  private readonly offset = new Vector3();

  /** Takes the mesh on if it is a wall. Its body must be where the scene puts it. */
  consider(mesh: Mesh, geometry: Geometry): void {
    if (geometry.kind !== "box") {
      return;
    }
    const up = new Vector3(0, 0, 1).transformDirection(mesh.matrixWorld.clone().invert());
    const vertical = AXES.find((axis) => Math.abs(up[axis]) > 0.99);
    if (vertical === undefined) {
      return;
    }
    const height = mesh.scale[vertical];
    const [thin] = AXES.filter((axis) => axis !== vertical).sort(
      (a, b) => mesh.scale[a] - mesh.scale[b],
    );
    if (thin === undefined || mesh.scale[thin] > THICKNESS_MAX_M) {
      return;
    }
    const bottom = new Vector3().setFromMatrixPosition(mesh.matrixWorld).z - height / 2;
    const isLintel = bottom > LINTEL_BOTTOM_M;
    if (height < HEIGHT_MIN_M && !isLintel) {
      return;
    }
    const down = new Vector3().setComponent(AXES.indexOf(vertical), -Math.sign(up[vertical]));
    this.walls.set(mesh, {
      mesh,
      vertical,
      thin,
      height,
      kerb: isLintel ? 0 : Math.min(KERB_M, height),
      down: down.applyQuaternion(mesh.quaternion),
      centre: mesh.position.clone(),
      lowered: 0,
      inTheWay: false,
    });
  }

  forget(mesh: Mesh): void {
    this.walls.delete(mesh);
  }

  /** Moves the walls for `dtSecs`; true when one moved. Allocates nothing. */
  update(camera: Vector3, target: Vector3, dtSecs: number): boolean {
    let moved = false;
    for (const wall of this.walls.values()) {
      this.look(wall, camera, target);
      const goal = wall.inTheWay ? 1 : 0;
      if (wall.lowered === goal) {
        continue;
      }
      const step = Math.min(1, RATE_PER_SEC * dtSecs);
      wall.lowered += (goal - wall.lowered) * step;
      if (Math.abs(goal - wall.lowered) < 0.01) {
        wall.lowered = goal;
      }
      this.apply(wall);
      moved = true;
    }
    return moved;
  }

  private look(wall: Wall, camera: Vector3, target: Vector3): void {
    const body = wall.mesh.parent;
    if (body === null) {
      return;
    }
    this.centre.copy(wall.centre).applyMatrix4(body.matrixWorld);
    this.normal.setFromMatrixColumn(wall.mesh.matrixWorld, AXES.indexOf(wall.thin)).normalize();
    const cameraSide = this.offset.copy(camera).sub(this.centre).dot(this.normal);
    const targetSide = this.offset.copy(target).sub(this.centre).dot(this.normal);
    if (Math.abs(cameraSide) > DEADBAND_M && Math.abs(targetSide) > DEADBAND_M) {
      wall.inTheWay = cameraSide * targetSide < 0;
    }
  }

  private apply(wall: Wall): void {
    const { mesh } = wall;
    const height = wall.height + (wall.kerb - wall.height) * wall.lowered;
    mesh.visible = height > 0.02;
    mesh.scale[wall.vertical] = height;
    mesh.position.copy(wall.centre).addScaledVector(wall.down, (wall.height - height) / 2);
  }
}
