// Teaching in a headset: Factotum's own studio, the page in a real browser, and a headset that is emulated (IWER).
//
// Skips, and says how to get what is missing, where there is no Chromium or no cargo. With FACTOTUM_PICTURES naming a
// folder, pictures of the steps are left there.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { after, before, describe, it } from "node:test";

import { findChromium, HOW_TO_GET_IT, launch } from "./chromium.mjs";
import { emptyHome } from "./empty_home.mjs";
import { inXr, pointInMap, pointInXr, Wearer } from "./headset.mjs";
import { onPage } from "./on_page.mjs";
import { build, FACTOTUM, REPOSITORY, start } from "./program.mjs";

const executablePath = findChromium();
const factotum = executablePath === null ? null : build(FACTOTUM);
const skip =
  (executablePath === null && HOW_TO_GET_IT) || (factotum === null && "no cargo to build Factotum with");

const PICTURES = process.env.FACTOTUM_PICTURES;
/** Few pixels, since the processor draws them, but for pictures that people look at. */
const DEVICE = { viewport: PICTURES === undefined ? { width: 320, height: 240 } : { width: 1024, height: 640 } };

const AR = { modes: ["inline", "immersive-vr", "immersive-ar"], button: "Teach in the room (AR)" };
const VR = { modes: ["inline", "immersive-vr"], button: "Teach in the map (VR)" };
/** Axes of parts of the kinds that come with the robot, in Λ (`assets/objects`). */
const FAUCET = { origin: [0, 0, 0], axis: [0, 0, 1] };
const SWITCH = { origin: [0.01, 0, 0], axis: [0, -1, 0] };

describe("teaching in a headset", { skip, concurrency: false }, () => {
  let browser;

  before(async () => {
    browser = await launch(executablePath);
  });

  after(async () => {
    await browser?.close();
  });

  /** Wears a headset in a home of its own of which nothing is known but the map; afterwards looks at its folder. */
  async function wearing({ modes, button }, hands, teach, check) {
    const dir = mkdtempSync(join(tmpdir(), "factotum-xr-"));
    let studio;
    try {
      const home = emptyHome(factotum, dir);
      studio = await start(factotum, "studio", "--home", home, "--skills", join(dir, "skills"));
      let wearer;
      await onPage(
        browser,
        studio.url,
        DEVICE,
        async (page) => {
          await wearer.enter(button);
          await teach(wearer, page);
        },
        async (page) => {
          wearer = new Wearer(page, { modes, hands });
          await wearer.install();
        },
      );
      await studio.stop();
      const shown = execFileSync(factotum, ["home", "show", home, "--json"], { encoding: "utf8" });
      const text = (...path) => readFileSync(join(home, ...path), "utf8");
      check(JSON.parse(shown), text);
    } finally {
      await studio?.stop();
      rmSync(dir, { recursive: true, force: true });
    }
  }

  it("AR, controllers: places the robot, then teaches all three chores", async () => {
    await wearing(
      AR,
      false,
      async (wearer, page) => {
        await wearer.title("Where is the robot?");
        await picture(page, "xr-robot");
        await placeRobot(wearer, page);
        await teachToThrowAway(wearer, page);
        await teachFaucet(wearer, page);
        await teachSwitch(wearer, page);
        await wearer.title("Your home");
        await wearer.click("Leave");
        await page.getByRole("button", { name: AR.button }).waitFor();
        await page.getByRole("region", { name: "Teach", exact: true }).getByText("light switch 1").waitFor();
      },
      ({ options }, text) => {
        for (const option of ["(throw_away cylinder_1 bin_1)", "(shut faucet_1)", "(dim light_switch_1)"]) {
          assert.ok(options.includes(option), `${option} is among ${options}`);
        }
        assertTaughtToThrowAway(text);
        const faucet = text("classes", "faucet", "class.toml");
        const shut = section(faucet, "actions", "shut");
        assert.match(shut, /joint = "handle"/);
        assert.match(shut, /termination = 0\.0\b/);
        assert.match(shut, /initiation = 1\.3\b/);
        assert.match(shut, /effect = "closed"/);
        const dim = section(text("classes", "light_switch", "class.toml"), "actions", "dim");
        assert.match(dim, /termination = -0\.4\b/);
        assert.match(dim, /contact = "push"/);
        assert.match(dim, /effect = "off"/);
      },
    );
  });

  it("AR, hands: teaches to throw away, and asks for the robot again when the headset has lost its origin", async () => {
    await wearing(
      AR,
      true,
      async (wearer, page) => {
        await placeRobot(wearer, page);
        await teachToThrowAway(wearer, page);
        const { epoch } = await wearer.seen();
        await page.evaluate(() => globalThis.emulated.recenter());
        await wearer.title("Where is the robot?");
        await page.getByText(`Alignment ${epoch + 1}: the headset has lost its origin`).waitFor({ state: "attached" });
      },
      (_home, text) => assertTaughtToThrowAway(text),
    );
  });

  it("VR, controllers: teaches to throw away, goes elsewhere by the grip, turns with two hands, and undoes", async () => {
    await wearing(
      VR,
      false,
      async (wearer, page) => {
        await wearer.title("Your home");
        const first = await wearer.seen();
        // The floor two metres ahead comes half a metre nearer.
        await wearer.aim("left", [0, 0, -2]);
        await wearer.squeeze("left", 1);
        await wearer.carry("left", [0, 0, 0.5]);
        await wearer.squeeze("left", 0);
        const second = await wearer.seen();
        assert.equal(second.epoch, first.epoch + 1);
        near(second.mapFromXr.position, [0, first.mapFromXr.position[1] + 0.5, 0], "the person stands nearer");
        await page.getByText(`Alignment ${second.epoch}: moved by hand`).waitFor({ state: "attached" });

        await teachToThrowAway(wearer, page);
        await choose(wearer, "cylinder 1");
        await wearer.title("Where is cylinder 1?");
        const before = (await wearer.seen()).values;
        await turnWithTwoHands(wearer, Math.PI / 6);
        await wearer.saved();
        assert.match((await wearer.seen()).values, /turned 30°/);
        await wearer.click("Undo");
        await wearer.saved();
        await wearer.until("what was before", (was) => window.factotumHeadset()?.values === was, before);
      },
      (_home, text) => assertTaughtToThrowAway(text),
    );
  });

  it("VR, hands: teaches to throw away, slowly, and turns a thing with one hand", async () => {
    await wearing(
      VR,
      true,
      async (wearer, page) => {
        await wearer.click("Speed 100 %");
        await teachToThrowAway(wearer, page, 0.5);
        await choose(wearer, "cylinder 1");
        await wearer.title("Where is cylinder 1?");
        for (const speed of ["Speed 50 %", "Speed 25 %", "Speed 10 %", "Turn"]) {
          await wearer.click(speed);
        }
        await wearer.aim("right", await wearer.thing("held"));
        await wearer.press("right", 1);
        await wearer.twist("right", Math.PI / 4);
        await wearer.press("right", 0);
        await wearer.saved();
        assert.match((await wearer.seen()).values, /^x 30, y -30, z 70 cm, turned 45°/);
      },
      (_home, text) => assertTaughtToThrowAway(text),
    );
  });

  it("is not offered where the browser finds no headset, and the page says so", async () => {
    await onPage(browser, "http://127.0.0.1/", DEVICE, async (page) => {
      await page.getByText("This browser finds no headset").waitFor({ state: "attached" });
      assert.equal(await page.locator(".headset button").isVisible(), false);
    }, serve);
  });

  it("is not offered on a page that is not secure, although the emulator says that AR is there", async () => {
    await onPage(
      browser,
      "http://robot.test/",
      DEVICE,
      async (page) => {
        assert.equal(await page.evaluate(() => navigator.xr.isSessionSupported("immersive-ar")), true);
        await page.getByText("This page is not secure").waitFor({ state: "attached" });
        assert.equal(await page.locator(".headset button").isVisible(), false);
      },
      async (page) => {
        await new Wearer(page, { modes: AR.modes, hands: false }).install();
        await serve(page);
      },
    );
  });
});

/** Draws the stand-in for the robot 40 cm to the right and 30 cm nearer. */
async function placeRobot(wearer, page) {
  const before = await wearer.seen();
  const by = [0.4, 0, 0.3];
  await wearer.drag(before.robot, by);
  const now = await wearer.seen();
  near(now.robot, before.robot.map((value, axis) => value + by[axis]), "the robot has come along");
  assert.equal(now.epoch, before.epoch + 1);
  await page.getByText(`Alignment ${now.epoch}: by the robot`).waitFor({ state: "attached" });
  await wearer.click("Done");
  await wearer.title("Your home");
}

/**
 * A bin that comes with the robot, a bottle made of a cylinder, how it is held, and what is done with it. `speed` is the
 * share of the hand's way that things go.
 */
async function teachToThrowAway(wearer, page, speed = 1) {
  await newThing(wearer, "bin");
  await wearer.title("Where is bin 1?");
  await dragTo(wearer, [0.8, 0, 0], speed);
  await wearer.click("Back");

  await newThing(wearer, "Make it: cylinder");
  await wearer.title("Where is cylinder 1?");
  await dragTo(wearer, [0.3, -0.3, 0.7], speed);
  await picture(page, `xr-where`, wearer);
  await wearer.click("Next");

  await wearer.title("How is a cylinder held?");
  await wearer.click("Show a way to hold it");
  await wearer.title("Hold the cylinder");
  await dragBy(wearer, [0, 0, 0.03], speed);
  await picture(page, `xr-hold`, wearer);
  await wearer.click("Save");
  await wearer.title("How is a cylinder held?");
  await wearer.click("Next");

  await wearer.title("What can be done with a cylinder?");
  await wearer.click("Put it into something");
  await wearer.title("Do something with a cylinder");
  await dragBy(wearer, [0.02, 0, 0.05], speed);
  await name(wearer, "throw away");
  await picture(page, `xr-do`, wearer);
  await wearer.click("Save");
  await wearer.title("What can be done with a cylinder?");
  await wearer.click("Finish");
  await wearer.title("Your home");
}

function assertTaughtToThrowAway(text) {
  const cylinder = text("classes", "cylinder", "class.toml");
  const side = section(cylinder, "grasps", "side");
  assert.match(side, /provenance = "taught"/);
  // From 45 % of its height, three centimetres up.
  near(vector(side, "xyz"), [0, 0, 0.12], "the grasp");
  const away = section(cylinder, "actions", "throw_away");
  assert.match(away, /target_class = "bin"/);
  const objects = text("objects.toml");
  near(vector(section(objects, "objects", "cylinder_1"), "xyz"), [0.3, -0.3, 0.7], "the cylinder");
  near(vector(section(objects, "objects", "bin_1"), "xyz"), [0.8, 0, 0], "the bin");
}

async function teachFaucet(wearer, page) {
  await newThing(wearer, "faucet");
  await wearer.title("Where is faucet 1?");
  await dragTo(wearer, [-0.3, 0, 0.9]);
  await wearer.click("Next");
  await wearer.title("How is a faucet held?");
  await wearer.click("Show a way to hold it");
  await wearer.click("Begin above it");
  await wearer.click("Save");
  await wearer.title("How is a faucet held?");
  await wearer.click("Next");
  await wearer.click("Move a part of it");
  await wearer.title("Do something with a faucet");
  // To beyond the stops: from open to closed.
  await dragAbout(wearer, "initiation", [-0.3, 0, 0.9], FAUCET, 1.6);
  await dragAbout(wearer, "termination", [-0.3, 0, 0.9], FAUCET, -1.6);
  await name(wearer, "shut");
  await picture(page, "xr-joint", wearer);
  await wearer.click("Save");
  await wearer.title("What can be done with a faucet?");
  await wearer.click("Finish");
}

async function teachSwitch(wearer) {
  await newThing(wearer, "light switch");
  await wearer.title("Where is light switch 1?");
  await dragTo(wearer, [0, 0.2, 1.2]);
  await wearer.click("Next");
  await wearer.click("Show a way to hold it");
  await wearer.title("Hold the light switch");
  await wearer.click("Opening −");
  await wearer.click("Save");
  await wearer.title("How is a light switch held?");
  await wearer.click("Next");
  await wearer.click("Move a part of it");
  await wearer.title("Do something with a light switch");
  await dragAbout(wearer, "initiation", [0, 0.2, 1.2], SWITCH, 1.2);
  await dragAbout(wearer, "termination", [0, 0.2, 1.2], SWITCH, -1.2);
  await wearer.click("The gripper holds it");
  await name(wearer, "dim");
  await wearer.click("Save");
  await wearer.title("What can be done with a light switch?");
  await wearer.click("Finish");
}

async function newThing(wearer, label) {
  await wearer.title("Your home");
  await wearer.look([0, 0.4, -1.2]);
  await wearer.click("Teach a new thing");
  await wearer.title("What is it?");
  await wearer.pick(label);
}

async function choose(wearer, label) {
  await wearer.title("Your home");
  await wearer.pick(label);
}

/** Writes a name with the letters of the panel. */
async function name(wearer, text) {
  await wearer.click("Name it");
  await wearer.title("Name: what is it called?");
  await wearer.click("Clear");
  await wearer.type(text);
  await wearer.click("Done");
}

/** Drags what the step is about to a place of the map, from where its numbers say it is. */
async function dragTo(wearer, to, speed = 1) {
  const { values } = await wearer.seen();
  const now = /x (\S+), y (\S+), z (\S+) cm/.exec(values).slice(1).map((value) => Number(value) / 100);
  await dragBy(wearer, to.map((value, axis) => value - now[axis]), speed);
  await wearer.saved();
}

async function dragBy(wearer, way, speed = 1) {
  const thing = await wearer.thing("held");
  await wearer.drag(thing, inXr(way.map((value) => value / speed), await wearer.seen()));
}

/** Drags a part about its axis, by radians, on the arc. */
async function dragAbout(wearer, what, object, { origin, axis }, angle) {
  const seen = await wearer.seen();
  const centre = object.map((value, index) => value + origin[index]);
  const from = pointInMap(await wearer.thing(what), seen).map((value, index) => value - centre[index]);
  const to = turned(from, axis, angle).map((value, index) => value + centre[index]);
  const start = pointInXr(from.map((value, index) => value + centre[index]), seen);
  await wearer.drag(start, pointInXr(to, seen).map((value, index) => value - start[index]));
}

/** A vector turned about a unit axis (Rodrigues). */
function turned(v, axis, angle) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const along = v.reduce((sum, value, index) => sum + value * axis[index], 0);
  const [x, y, z] = axis;
  const across = [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]];
  return v.map((value, index) => value * cos + across[index] * sin + axis[index] * along * (1 - cos));
}

/** Takes what the step is about with the right hand, and turns it by carrying the left about the right. */
async function turnWithTwoHands(wearer, angle) {
  await wearer.aim("left", [0, 1, -3]);
  await wearer.aim("right", await wearer.thing("held"));
  await wearer.press("right", 1);
  await wearer.press("left", 1);
  const arm = wearer.at.left.map((value, axis) => value - wearer.at.right[axis]);
  const to = turned(arm, [0, 1, 0], angle);
  await wearer.carry("left", to.map((value, axis) => value - arm[axis]));
  await wearer.press("right", 0);
  await wearer.press("left", 0);
}

/** The part of a TOML file that is one named entry of a list. */
function section(toml, list, wanted) {
  const found = toml.split(/^(?=\[)/m).find((part) => part.startsWith(`[[${list}]]`) && part.includes(`name = "${wanted}"`));
  assert.ok(found !== undefined, `${list} of the name ${wanted} in:\n${toml}`);
  return found;
}

function vector(toml, key) {
  const found = new RegExp(`^${key} = \\[([^\\]]*)\\]`, "m").exec(toml);
  assert.ok(found !== null, `${key} in:\n${toml}`);
  return found[1].split(",", 3).map(Number);
}

function near(actual, wanted, what) {
  actual.forEach((value, axis) => {
    assert.ok(Math.abs(value - wanted[axis]) < 1e-3, `${what}: ${actual}, wanted ${wanted}`);
  });
}

async function picture(page, name, wearer) {
  if (PICTURES !== undefined) {
    await wearer?.look([-0.1, 0.9, -1.2]);
    await page.waitForTimeout(1500);
    await page.screenshot({ path: join(PICTURES, `${name}.png`) });
  }
}

/** Serves the built page alone, without a studio, whatever the address. */
async function serve(page) {
  const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
  await page.route("**/*", (route) => {
    const { pathname } = new URL(route.request().url());
    const file = pathname === "/" ? "/index.html" : pathname;
    if (file.startsWith("/api/")) {
      return route.fulfill({ status: 401 });
    }
    return route.fulfill({
      body: readFileSync(join(REPOSITORY, "web/dist", file)),
      contentType: types[extname(file)],
    });
  });
}
