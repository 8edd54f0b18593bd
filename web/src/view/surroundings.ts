// Light, ground and grid.

import {
  type Box3,
  Color,
  DirectionalLight,
  Fog,
  GridHelper,
  Group,
  HemisphereLight,
  LineBasicMaterial,
  Mesh,
  PlaneGeometry,
  type Scene,
  ShadowMaterial,
  Vector3,
} from "three";

import type { Theme } from "./theme";

const SUN_DIRECTION = new Vector3(0.34, 1, 0.5).normalize();
/** Intensities by day, together just short of what would wash out a white floor. */
const SKY = 1.75;
const SUN = 1.45;
const FILL = 0.3;
const SHADOW_PX = 2048;
const GROUND_M = 120;
const GRID_M = 60;

export class Surroundings {
  readonly root = new Group();
  private readonly sky = new HemisphereLight();
  private readonly sun = new DirectionalLight(0xfff4e4);
  private readonly fill = new DirectionalLight(0xdfeaff);
  private readonly shadows = new ShadowMaterial();
  private readonly ground: Mesh;
  private grid: GridHelper | null = null;
  private seesRoom = false;
  private theme: Theme | null = null;

  constructor(private readonly scene: Scene) {
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(SHADOW_PX, SHADOW_PX);
    this.sun.shadow.radius = 5;
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.02;
    this.fill.position.set(-6, 5, 3);
    this.ground = new Mesh(new PlaneGeometry(GROUND_M, GROUND_M).rotateX(-Math.PI / 2), this.shadows);
    this.ground.position.y = -0.004;
    this.ground.receiveShadow = true;
    this.root.add(this.sky, this.sun, this.sun.target, this.fill, this.ground);
  }

  /** Spreads the shadows over the home and no farther, which keeps them sharp. */
  fit(box: Box3): void {
    if (box.isEmpty()) {
      return;
    }
    const centre = box.getCenter(new Vector3());
    const radius = 0.5 * box.getSize(new Vector3()).length() + 0.5;
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).addScaledVector(SUN_DIRECTION, 2 * radius);
    const { camera } = this.sun.shadow;
    camera.left = -radius;
    camera.right = radius;
    camera.top = radius;
    camera.bottom = -radius;
    camera.near = 0.1;
    camera.far = 4 * radius;
    camera.updateProjectionMatrix();
  }

  /**
   * For eyes in a headset: without shadows, since it draws everything twice and often; and, where the room is seen behind
   * the picture, without what would hide it. Null is for eyes before a screen.
   */
  lookedAtBy(eyes: { readonly seesRoom: boolean } | null): void {
    this.sun.castShadow = eyes === null;
    this.seesRoom = eyes?.seesRoom === true;
    if (this.theme !== null) {
      this.setTheme(this.theme);
    }
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    const background = new Color(theme.background);
    this.scene.background = this.seesRoom ? null : background;
    this.scene.fog = this.seesRoom ? null : new Fog(background, 22, 60);
    this.ground.visible = !this.seesRoom;
    this.sky.intensity = SKY * theme.light;
    this.sun.intensity = SUN * theme.light;
    this.fill.intensity = FILL * theme.light;
    this.sky.color.set(theme.sky);
    this.sky.groundColor.set(theme.ground);
    this.shadows.opacity = theme.shadowOpacity;
    if (this.grid !== null) {
      this.root.remove(this.grid);
      this.grid.dispose();
    }
    this.grid = new GridHelper(GRID_M, GRID_M, theme.gridLineStrong, theme.gridLine);
    this.grid.position.y = -0.006;
    if (this.grid.material instanceof LineBasicMaterial) {
      this.grid.material.depthWrite = false;
    }
    this.grid.visible = !this.seesRoom;
    this.root.add(this.grid);
  }
}
