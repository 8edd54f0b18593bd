// Gives up sharpness for smoothness where the machine cannot have both, unless the address ends in
// `#sharp`, as it does for pictures.

/** Slower than this, turning the view feels sticky. */
const FRAME_SLOW_MILLIS = 45;
const FRAMES_JUDGED = 20;
const PIXEL_RATIO_MAX = 2;
const PIXEL_RATIO_MIN = 0.75;
const STEP = 0.75;
const SHARP = "#sharp";

export class Quality {
  pixelRatio = Math.min(window.devicePixelRatio, PIXEL_RATIO_MAX);
  private n_frames = 0;
  private sumMillis = 0;

  /** Notes the time since the frame before, both having been drawn; true when it has changed. */
  note(frameMillis: number): boolean {
    if (window.location.hash === SHARP) {
      return false;
    }
    this.sumMillis += frameMillis;
    this.n_frames += 1;
    if (this.n_frames < FRAMES_JUDGED) {
      return false;
    }
    const mean = this.sumMillis / this.n_frames;
    this.n_frames = 0;
    this.sumMillis = 0;
    if (mean < FRAME_SLOW_MILLIS || this.pixelRatio <= PIXEL_RATIO_MIN) {
      return false;
    }
    this.pixelRatio = Math.max(PIXEL_RATIO_MIN, STEP * this.pixelRatio);
    return true;
  }
}
