// A virtual gripper: two fingers and a palm about the tool frame, z along the approach, x along the closing direction.
// No robot's in particular, since a grasp belongs to the class and not to a hand.

import { BoxGeometry, Group, type Material, Mesh } from "three";

/** Metres: fingers reach this far beyond the tool frame and before it. */
const TIP = 0.012;
const FINGER = 0.075;
const THICK = 0.012;
const WIDE = 0.022;
const PALM = 0.02;
const ARM = 0.06;

const box = new BoxGeometry(1, 1, 1);

/** A gripper open by `aperture` metres. Its geometry is shared. */
export function gripper(aperture: number, material: Material): Group {
  const group = new Group();
  const add = (x: number, z: number, width: number, depth: number, height: number): void => {
    const mesh = new Mesh(box, material);
    mesh.position.set(x, 0, z);
    mesh.scale.set(width, depth, height);
    group.add(mesh);
  };
  const side = 0.5 * aperture + 0.5 * THICK;
  const middle = 0.5 * (TIP - FINGER);
  add(side, middle, THICK, WIDE, TIP + FINGER);
  add(-side, middle, THICK, WIDE, TIP + FINGER);
  add(0, -FINGER - 0.5 * PALM, aperture + 2 * THICK, 1.4 * WIDE, PALM);
  add(0, -FINGER - PALM - 0.5 * ARM, 1.6 * WIDE, 1.6 * WIDE, ARM);
  return group;
}
