// A headset that is not there: Meta's emulator (IWER) in the page, and a person who wears it.
//
// It is put in before the page's own scripts run, and by force: browsers have a WebXR of their own, which finds nothing.

import { fileURLToPath } from "node:url";

const IWER = fileURLToPath(new URL("../node_modules/iwer/build/iwer.min.js", import.meta.url));

/** Where the hands rest, in XR: metres, y up, -z ahead. */
const REST = { left: [-0.25, 1.35, -0.3], right: [0.25, 1.35, -0.3] };
/** Pictures of a drag. */
const DRAG_STEPS = 2;

export class Wearer {
  /** `modes` are those that the headset offers; it has controllers, or hands that pinch. */
  constructor(page, { modes, hands }) {
    this.page = page;
    this.modes = modes;
    this.hands = hands;
    this.at = { left: REST.left, right: REST.right };
    this.turned = { left: [0, 0, 0, 1], right: [0, 0, 0, 1] };
  }

  /** Puts the emulator into all pages that are opened from now on. */
  async install() {
    await this.page.addInitScript({ path: IWER });
    await this.page.addInitScript(
      ({ modes, hands }) => {
        const { XRDevice, metaQuest3 } = globalThis.IWER;
        const device = new XRDevice({ ...metaQuest3, supportedSessionModes: modes });
        device.installRuntime({ forceInstall: true });
        device.primaryInputMode = hands ? "hand" : "controller";
        device.position.set(0, 1.6, 0);
        // What is seen of the room is as plain as can be.
        device.canvasContainer.style.background = "linear-gradient(#c9c2b8 0 45%, #a99a86 45%)";
        globalThis.emulated = device;
      },
      { modes: this.modes, hands: this.hands },
    );
  }

  /** Enters by the page's button, as a click of a person. */
  async enter(name) {
    await this.page.getByRole("button", { name }).click();
    await this.page.waitForFunction(() => (window.factotumHeadset?.()?.buttons.length ?? 0) > 0);
    await this.frames(1);
  }

  seen() {
    return this.page.evaluate(() => window.factotumHeadset?.() ?? null);
  }

  /** Waits for pictures: what hands do is heard of in the next one. */
  frames(n) {
    return this.page.evaluate(async (count) => {
      for (let frame = 0; frame < count; frame++) {
        await new Promise((drawn) => requestAnimationFrame(drawn));
      }
    }, n);
  }

  async until(what, test, argument) {
    try {
      await this.page.waitForFunction(test, argument, { timeout: 60_000 });
    } catch {
      const seen = await this.seen();
      const labels = seen?.buttons.map(({ label, isDisabled }) => (isDisabled ? `(${label})` : label));
      throw new Error(`${what} has not come; the panel says ${JSON.stringify({ ...seen, buttons: labels })}`);
    }
  }

  /** Waits until the panel has this title. */
  title(text) {
    return this.until(`the title "${text}"`, (wanted) => window.factotumHeadset?.()?.title === wanted, text);
  }

  /** Waits until an edit that was asked for is done. */
  saved() {
    return this.until("the end of saving", () => window.factotumHeadset?.()?.notice === "");
  }

  async hold(hand, at, turned) {
    this.at[hand] = at;
    this.turned[hand] = turned;
    await this.page.evaluate(
      ({ hand, at, turned, hands }) => {
        const input = hands ? globalThis.emulated.hands[hand] : globalThis.emulated.controllers[hand];
        input.position.set(...at);
        input.quaternion.set(...turned);
      },
      { hand, at, turned, hands: this.hands },
    );
    await this.frames(1);
  }

  /** Points at a place from where the hand rests. */
  aim(hand, at) {
    return this.hold(hand, REST[hand], towards(REST[hand], at));
  }

  async squeeze(hand, value) {
    await this.page.evaluate(
      ({ hand, value }) => globalThis.emulated.controllers[hand].updateButtonValue("squeeze", value),
      { hand, value },
    );
    await this.frames(1);
  }

  /** Pulls the trigger or pinches (1), or lets go (0), and waits for so many pictures. */
  async press(hand, value, frames = 1) {
    await this.page.evaluate(
      ({ hand, value, hands }) => {
        if (hands) {
          globalThis.emulated.hands[hand].updatePinchValue(value);
        } else {
          globalThis.emulated.controllers[hand].updateButtonValue("trigger", value);
        }
      },
      { hand, value, hands: this.hands },
    );
    await this.frames(frames);
  }

  /** Points at a button of the panel and presses it, when it can be pressed. */
  async click(label, hand = "right") {
    await this.until(
      `the button "${label}"`,
      (wanted) => {
        const seen = window.factotumHeadset?.();
        const found = seen?.buttons.find((button) => button.label === wanted);
        return found !== undefined && !found.isDisabled;
      },
      label,
    );
    const { buttons } = await this.seen();
    await this.aim(hand, buttons.find((button) => button.label === label).at);
    await this.press(hand, 1);
    await this.press(hand, 0, 0);
  }

  /** Presses a button of a list, on whichever of its pages it is. */
  async pick(label) {
    for (;;) {
      const { buttons } = await this.seen();
      const more = buttons.find((button) => button.label === "More ›");
      if (buttons.some((button) => button.label === label) || more === undefined || more.isDisabled) {
        return this.click(label);
      }
      await this.click(more.label);
      await this.frames(1);
    }
  }

  async type(text) {
    for (const letter of text) {
      await this.click(letter === " " ? "space" : letter);
    }
  }

  /** Takes hold at one place and lets go where it has been carried by a way, turned about the upright on the way. */
  async drag(from, by, { hand = "right", release = true } = {}) {
    await this.aim(hand, from);
    await this.press(hand, 1);
    await this.carry(hand, by);
    if (release) {
      await this.press(hand, 0);
    }
  }

  async carry(hand, by) {
    const start = this.at[hand];
    for (let step = 1; step <= DRAG_STEPS; step++) {
      const share = step / DRAG_STEPS;
      await this.hold(hand, start.map((value, axis) => value + share * by[axis]), this.turned[hand]);
    }
  }

  /** Takes hold and turns the hand about the upright, by radians. */
  async twist(hand, angle) {
    const start = this.turned[hand];
    for (let step = 1; step <= DRAG_STEPS; step++) {
      const half = (0.5 * angle * step) / DRAG_STEPS;
      await this.hold(hand, this.at[hand], times([0, Math.sin(half), 0, Math.cos(half)], start));
    }
  }

  async thing(what) {
    await this.until(
      `the thing "${what}"`,
      (wanted) => window.factotumHeadset?.()?.things.some((thing) => thing.what === wanted) === true,
      what,
    );
    const { things } = await this.seen();
    return things.find((thing) => thing.what === what).at;
  }

  async look(at) {
    await this.page.evaluate(
      ({ from, turned }) => {
        globalThis.emulated.position.set(...from);
        globalThis.emulated.quaternion.set(...turned);
      },
      { from: [0, 1.6, 0], turned: towards([0, 1.6, 0], at) },
    );
    await this.frames(1);
  }
}

/** A way in the map as one in XR. */
export function inXr([x, y, z], { mapFromXr: { yaw } }) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return [cos * x + sin * y, z, sin * x - cos * y];
}

/** A point of the map in XR. */
export function pointInXr(point, seen) {
  return inXr(point.map((value, axis) => value - seen.mapFromXr.position[axis]), seen);
}

/** A point of XR in the map. */
export function pointInMap([x, y, z], { mapFromXr: { yaw, position } }) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  return [position[0] + cos * x + sin * z, position[1] + sin * x - cos * z, position[2] + y];
}

/** The orientation (xyzw) that looks along -z from one place to another, upright. */
export function towards(from, to) {
  const [x, y, z] = to.map((value, axis) => value - from[axis]);
  const yaw = Math.atan2(-x, -z);
  const pitch = Math.atan2(y, Math.hypot(x, z));
  return times([0, Math.sin(yaw / 2), 0, Math.cos(yaw / 2)], [Math.sin(pitch / 2), 0, 0, Math.cos(pitch / 2)]);
}

function times([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}
