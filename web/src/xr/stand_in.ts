// Stands in the map where a robot would, for homes with which none is connected: a base, a column, an arrow ahead. No
// robot's own model.

import { BoxGeometry, ConeGeometry, CylinderGeometry, Group, Mesh, MeshLambertMaterial } from "three";

const BASE = { radius: 0.3, height: 0.25 } as const;
const COLUMN = { width: 0.16, height: 0.9 } as const;
const ARROW = { radius: 0.1, length: 0.25 } as const;

/** The stand-in, in the map's frame: x ahead, z up, its foot at the origin. */
export function standIn(colour: number): Group {
  const group = new Group();
  const material = new MeshLambertMaterial({ color: colour, transparent: true, opacity: 0.7 });
  const base = new Mesh(new CylinderGeometry(BASE.radius, BASE.radius, BASE.height, 40), material);
  base.rotation.x = Math.PI / 2;
  base.position.z = BASE.height / 2;
  const column = new Mesh(new BoxGeometry(COLUMN.width, COLUMN.width, COLUMN.height), material);
  column.position.z = BASE.height + COLUMN.height / 2;
  const arrow = new Mesh(new ConeGeometry(ARROW.radius, ARROW.length, 24), material);
  arrow.rotation.z = -Math.PI / 2;
  arrow.position.set(BASE.radius + ARROW.length / 2, 0, BASE.height / 2);
  group.add(base, column, arrow);
  return group;
}
