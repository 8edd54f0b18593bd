// The camera: turned about a point by hand, first placed to show the whole home, and carried along
// by the robot when it is followed.

import { type Box3, PerspectiveCamera, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { yUpFromZUp, zUpFromYUp } from "../frames";
import type { State } from "../protocol";

const FIELD_OF_VIEW_DEG = 38;
/** Where the first picture is taken from: over the home's near right corner. */
const AZIMUTH_RAD = 0.55;
const POLAR_RAD = 0.72;
/** Room around the home in the first picture. */
const MARGIN = 1.06;
/** How far the picture is lifted, since buttons cover its foot. */
const LIFT_PX = 24;
const FOLLOW_DISTANCE_M = 6;
/** What the camera looks at on a robot, above the floor. */
const FOLLOW_HEIGHT_M = 0.6;
/** Part of the way that a followed target is caught up in a second. */
const FOLLOW_RATE_PER_SEC = 5;
const KEY_TURN_RAD = 0.12;
const KEY_ZOOM = 0.88;

export class CameraRig {
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.05, 300);
  readonly controls: OrbitControls;
  private fitted: Box3 | null = null;
  private touched = false;
  private followed = false;
  private readonly goal = new Vector3();
  private readonly step = new Vector3();
  private readonly spherical = new Spherical();
  private readonly calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  constructor(canvas: HTMLCanvasElement, onChange: () => void) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.minDistance = 0.6;
    this.controls.maxDistance = 60;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", onChange);
    this.controls.addEventListener("start", () => {
      this.touched = true;
    });
    this.camera.position.setFromSphericalCoords(12, POLAR_RAD, AZIMUTH_RAD);
    this.controls.update();
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.setViewOffset(width, height, 0, LIFT_PX, width, height);
    if (this.fitted !== null && !this.touched && !this.followed) {
      this.fit(this.fitted);
    }
  }

  /** Shows the whole of a box, unless a person has already chosen a view. */
  fit(box: Box3): void {
    this.fitted = box;
    if (this.touched || this.followed || box.isEmpty()) {
      return;
    }
    const { camera } = this;
    const centre = box.getCenter(new Vector3());
    centre.y = box.min.y;
    const direction = new Vector3().setFromSphericalCoords(1, POLAR_RAD, AZIMUTH_RAD);
    camera.position.copy(centre).add(direction);
    camera.lookAt(centre);
    camera.updateMatrixWorld();
    const slopeY = Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    const slopeX = slopeY * camera.aspect;
    // The smallest distance from which every corner of the floor is within both slopes.
    let distance = 0;
    const corner = new Vector3();
    for (const x of [box.min.x, box.max.x]) {
      for (const y of [box.min.y, box.max.y]) {
        for (const z of [box.min.z, box.max.z]) {
          corner.set(x, y, z).applyMatrix4(camera.matrixWorldInverse);
          const toEye = corner.z + 1;
          distance = Math.max(
            distance,
            Math.abs(corner.x) / slopeX + toEye,
            Math.abs(corner.y) / slopeY + toEye,
          );
        }
      }
    }
    camera.position.copy(centre).addScaledVector(direction, distance * MARGIN);
    this.controls.target.copy(centre);
    this.controls.update();
  }

  /** Looks at a point of the wire's world from so far, in the direction in which it looked before. */
  lookAt([x, y, z]: readonly [number, number, number], distance: number): void {
    const { camera, controls } = this;
    this.touched = true;
    this.step.copy(camera.position).sub(controls.target).setLength(distance);
    yUpFromZUp(x, y, z, controls.target);
    camera.position.copy(controls.target).add(this.step);
    controls.update();
  }

  /** Where on the floor of the wire's world it looks. */
  lookedAt(): [number, number] {
    const at = zUpFromYUp(this.controls.target.x, this.controls.target.y, this.controls.target.z, this.goal);
    return [at.x, at.y];
  }

  follow(followed: boolean): void {
    const { camera, controls } = this;
    if (followed && !this.followed) {
      this.step.copy(camera.position).sub(controls.target).clampLength(0, FOLLOW_DISTANCE_M);
      camera.position.copy(controls.target).add(this.step);
    }
    this.followed = followed;
    if (!followed && !this.touched && this.fitted !== null) {
      this.fit(this.fitted);
    }
  }

  /** Carries the camera along; true while it moves. Allocates nothing. */
  update(state: State | null, dtSecs: number): boolean {
    if (!this.followed || state === null) {
      return false;
    }
    const { camera, controls } = this;
    yUpFromZUp(state.base.x, state.base.y, FOLLOW_HEIGHT_M, this.goal);
    this.step.copy(this.goal).sub(controls.target);
    if (!Number.isFinite(this.step.lengthSq()) || this.step.lengthSq() < 1e-8) {
      return false;
    }
    const part = this.calm.matches ? 1 : Math.min(1, FOLLOW_RATE_PER_SEC * dtSecs);
    this.step.multiplyScalar(part);
    controls.target.add(this.step);
    camera.position.add(this.step);
    controls.update();
    return true;
  }

  private key(event: KeyboardEvent): void {
    const { camera, controls } = this;
    this.step.copy(camera.position).sub(controls.target);
    this.spherical.setFromVector3(this.step);
    switch (event.key) {
      case "ArrowLeft":
        this.spherical.theta -= KEY_TURN_RAD;
        break;
      case "ArrowRight":
        this.spherical.theta += KEY_TURN_RAD;
        break;
      case "ArrowUp":
        this.spherical.phi -= KEY_TURN_RAD;
        break;
      case "ArrowDown":
        this.spherical.phi += KEY_TURN_RAD;
        break;
      case "+":
      case "=":
        this.spherical.radius *= KEY_ZOOM;
        break;
      case "-":
        this.spherical.radius /= KEY_ZOOM;
        break;
      default:
        return;
    }
    event.preventDefault();
    this.touched = true;
    this.spherical.phi = Math.min(Math.max(this.spherical.phi, 0.02), controls.maxPolarAngle);
    camera.position.copy(controls.target).add(this.step.setFromSpherical(this.spherical));
    controls.update();
  }
}
