// Robot, home and belief: a group for each body, meshes for its shapes.

import {
  type Box3,
  Color,
  Group,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Mesh,
  MeshLambertMaterial,
  SRGBColorSpace,
} from "three";

import { isFinitePose, place } from "../frames";
import type { Body, Scene, SceneSource, Shape, State } from "../protocol";
import { Cutaway } from "./cutaway";
import { isShared, shown } from "./geometries";
import type { Theme } from "./theme";

/** How far what is only believed can be seen through. */
const BELIEF_OPACITY = 0.45;

export class Bodies {
  readonly root = new Group();
  readonly cutaway = new Cutaway();
  private readonly sources = new Map<SceneSource, { scene: Scene; group: Group }>();
  private readonly byName = new Map<string, Group>();
  private hidden: string | null = null;
  private readonly materials = new Map<string, MeshLambertMaterial>();
  private readonly edgeMaterial = new LineBasicMaterial({ transparent: true, depthWrite: false });

  get count(): number {
    return this.byName.size;
  }

  /** Shows these scenes; only those that are new are built. */
  show(scenes: ReadonlyMap<SceneSource, Scene>): void {
    for (const [source, { scene }] of this.sources) {
      if (scenes.get(source) !== scene) {
        this.remove(source);
      }
    }
    for (const [source, scene] of scenes) {
      if (!this.sources.has(source)) {
        this.add(source, scene);
      }
    }
  }

  /** Moves the bodies that the state names. Allocates nothing. */
  move(state: State): void {
    for (const { name, pose } of state.body_poses) {
      const body = this.byName.get(name);
      if (body !== undefined && isFinitePose(pose)) {
        place(body, pose);
      }
    }
  }

  /** Draws all bodies but this one. */
  hide(name: string | null): void {
    this.hidden = name;
    for (const [other, body] of this.byName) {
      body.visible = other !== name;
    }
  }

  /** Where the whole of a body's shapes lies in the scene; false where there is no such body. */
  boxOf(name: string, out: Box3): boolean {
    const body = this.byName.get(name);
    if (body === undefined) {
      return false;
    }
    out.setFromObject(body);
    return !out.isEmpty();
  }

  setTheme(theme: Theme): void {
    this.edgeMaterial.color.set(theme.edge);
    this.edgeMaterial.opacity = theme.edgeOpacity;
  }

  private add(source: SceneSource, scene: Scene): void {
    const group = new Group();
    for (const body of scene.bodies) {
      const made = this.body(body, source);
      made.visible = body.name !== this.hidden;
      this.byName.set(body.name, made);
      group.add(made);
    }
    this.sources.set(source, { scene, group });
    this.root.add(group);
  }

  private remove(source: SceneSource): void {
    const old = this.sources.get(source);
    if (old === undefined) {
      return;
    }
    this.sources.delete(source);
    for (const body of old.scene.bodies) {
      this.byName.delete(body.name);
    }
    old.group.traverse((object) => {
      if (object instanceof Mesh) {
        this.cutaway.forget(object);
        if (!isShared(object.geometry)) {
          object.geometry.dispose();
        }
      }
    });
    this.root.remove(old.group);
  }

  private body(body: Body, source: SceneSource): Group {
    const group = new Group();
    group.name = body.name;
    place(group, body.pose);
    for (const shape of body.shapes) {
      const mesh = this.shape(shape, source);
      if (mesh !== null) {
        group.add(mesh);
        if (source === "home") {
          group.updateMatrixWorld(true);
          this.cutaway.consider(mesh, shape.geometry);
        }
      }
    }
    return group;
  }

  private shape(shape: Shape, source: SceneSource): Mesh | null {
    const what = shown(shape.geometry);
    if (what === null) {
      return null;
    }
    const material = this.material(shape.rgba, source);
    const mesh = new Mesh(what.geometry, material);
    mesh.scale.copy(what.scale);
    place(mesh, shape.pose);
    const solid = !material.transparent;
    mesh.castShadow = solid;
    mesh.receiveShadow = solid;
    if (what.edges !== null && source === "home") {
      mesh.add(new LineSegments(what.edges, this.edgeMaterial as Material));
    }
    return mesh;
  }

  private material(rgba: Shape["rgba"], source: SceneSource): MeshLambertMaterial {
    const opacity = rgba[3] * (source === "belief" ? BELIEF_OPACITY : 1);
    const key = `${rgba.slice(0, 3).join("/")}/${opacity}`;
    let material = this.materials.get(key);
    if (material === undefined) {
      const color = new Color().setRGB(rgba[0], rgba[1], rgba[2], SRGBColorSpace);
      const transparent = opacity < 0.999;
      material = new MeshLambertMaterial({ color, transparent, opacity, depthWrite: !transparent });
      this.materials.set(key, material);
    }
    return material;
  }
}
