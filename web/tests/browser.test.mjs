// The page in a real browser, against a real studio.
//
// Skips, and says how to get what is missing, where there is no Chromium or no cargo.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { findChromium, HOW_TO_GET_IT, launch, untilDrawn } from "./chromium.mjs";
import { DESKTOP, onPage as onPageOf, overflowOf, PHONE, SMALL } from "./on_page.mjs";
import { build, DEMO, start } from "./program.mjs";

const executablePath = findChromium();
const demo = executablePath === null ? null : build(DEMO);
const skip =
  (executablePath === null && HOW_TO_GET_IT) || (demo === null && "no cargo to build the demo with");

/** In the middle of the plan, with a step that was tried twice. */
const MID_PLAN = ["--start", "29", "--speed", "0.1"];

describe("the page", { skip, concurrency: false }, () => {
  let browser;
  let studio;

  before(async () => {
    browser = await launch(executablePath);
    studio = await start(demo, ...MID_PLAN);
  });

  after(async () => {
    await studio?.stop();
    await browser?.close();
  });

  const onPage = (url, device, look) => onPageOf(browser, url, device, look);

  it("draws the home and says what the robot is at", async () => {
    await onPage(studio.url, DESKTOP, async (page) => {
      await untilDrawn(page);
      assert.equal(new URL(page.url()).search, "", "the token has left the address");
      assert.ok((await coloursOf(page)) > 300, "the picture is more than a plain ground");
      assert.equal(await page.textContent(".connection"), "Live");
      assert.equal(await page.textContent(".chip"), "Acting");
      assert.match(await page.textContent(".goal"), /bottle in the bin/);
      assert.match(await page.getAttribute("canvas", "aria-label"), /\d+ bodies/);
      assert.equal(await page.getByRole("group", { name: "Drive by hand" }).isVisible(), false);
    });
  });

  it("shows the plan with states in words, and why a step was tried again", async () => {
    await onPage(studio.url, DESKTOP, async (page) => {
      await page.waitForSelector(".steps li[aria-current='step']");
      const states = await page.$$eval(".steps .state", (all) => all.map((one) => one.textContent));
      assert.equal(states.length, 8);
      assert.equal(states[1], "done · 2 tries");
      assert.equal(states[2], "doing");
      assert.equal(states[7], "to do");
      assert.match(await page.textContent(".steps .reason"), /slipped/);
      assert.equal((await page.$$(".regions li")).length, 4);
      assert.match(await page.textContent(".events"), /Warning: 0:25/);
      assert.equal(await page.getAttribute(".events", "aria-live"), "polite");
    });
  });

  it("changes the view by keys and by buttons alike", async () => {
    await onPage(studio.url, DESKTOP, async (page) => {
      await untilDrawn(page);
      for (const [key, name, pressed] of [
        ["f", "Follow", "true"],
        ["m", "Map", "false"],
        ["r", "Regions", "false"],
        ["l", "Labels", "false"],
      ]) {
        const button = page.getByRole("button", { name });
        await page.keyboard.press(key);
        assert.equal(await button.getAttribute("aria-pressed"), pressed, name);
        await button.click();
        assert.notEqual(await button.getAttribute("aria-pressed"), pressed, name);
      }
    });
  });

  it("fits a phone without scrolling sideways", async () => {
    await onPage(studio.url, PHONE, async (page) => {
      await untilDrawn(page);
      const overflow = await overflowOf(page);
      const { canvas, stage } = await page.evaluate(() => ({
        canvas: document.querySelector("canvas").getBoundingClientRect().toJSON(),
        stage: document.querySelector("#stage").getBoundingClientRect().toJSON(),
      }));
      assert.ok(overflow <= 0, `${overflow} pixels too wide`);
      assert.deepEqual(canvas, stage, "the picture fills its place");
      for (const button of await page.$$(".controls > .group button")) {
        const box = await button.boundingBox();
        assert.ok(box.width >= 44 && box.height >= 44, "a finger hits every button");
      }
    });
  });

  it("pauses with the space bar, goes on, and stops only when asked twice", async () => {
    const own = await start(demo, ...MID_PLAN);
    try {
      await onPage(own.url, DESKTOP, async (page) => {
        const chip = (text) => page.locator(".chip", { hasText: text }).waitFor();
        await chip("Acting");
        await page.keyboard.press(" ");
        await chip("Paused");
        await page.getByRole("button", { name: "Go on" }).click();
        await chip("Acting");
        await page.keyboard.press("s");
        await page.keyboard.press("Escape");
        await page.waitForTimeout(300);
        await chip("Acting");
        await page.keyboard.press("s");
        await page.keyboard.press("Enter");
        await chip("Stopped");
        await page.locator(".outcome", { hasText: "Not achieved" }).waitFor();
        assert.equal(await page.getByRole("button", { name: "Stop" }).isDisabled(), true);
      });
    } finally {
      await own.stop();
    }
  });

  it("drives by keys and by fingers while the job takes it, and says when it is done", async () => {
    const own = await start(demo, "--drive", "4", "--start", "4", "--speed", "0.1");
    try {
      await onPage(own.url, SMALL, async (page) => {
        const says = (text) => page.locator(".events li", { hasText: text }).last().waitFor();
        const pad = page.getByRole("group", { name: "Drive by hand" });
        await pad.waitFor();
        await page.keyboard.down("w");
        await says("hand: forward 1, left 0, turn 0");
        await page.keyboard.down("q");
        await says("hand: forward 1, left 0, turn 1");
        await page.keyboard.up("w");
        await page.keyboard.up("q");
        await says("hand: forward 0, left 0, turn 0");
        await page.keyboard.down("ArrowRight");
        await says("hand: forward 0, left -1, turn 0");
        await page.keyboard.up("ArrowRight");

        const back = pad.getByRole("button", { name: "Back" });
        await back.hover();
        await page.mouse.down();
        await says("hand: forward -1, left 0, turn 0");
        await page.evaluate(() => window.dispatchEvent(new Event("blur")));
        assert.equal((await page.$$(".drive-pad .held")).length, 0, "a page left alone lets go");
        await page.mouse.up();

        await page.keyboard.press("s");
        assert.equal(await page.locator("dialog").isVisible(), true, "S is still the page's Stop");
        await page.keyboard.press("Escape");
        // A page that draws by software on a busy machine may be silent for a second; the robot then rests, as it should.
        const warned = await page.locator(".events li[data-level='warning']").allTextContents();
        assert.deepEqual(warned.filter((text) => !text.includes("fallen silent")), []);
        await pad.getByRole("button", { name: "Done" }).click();
        await says("driving by hand ends");
        await pad.waitFor({ state: "hidden" });
      });
    } finally {
      await own.stop();
    }
  });

  it("says that the connection is lost, and comes back to the same run or says it is another", async () => {
    const first = await start(demo, ...MID_PLAN);
    let second;
    try {
      await onPage(first.url, DESKTOP, async (page) => {
        const says = (text) => page.locator(".connection", { hasText: text }).waitFor();
        await says("Live");
        await first.stop();
        await says("Connection lost");
        assert.equal((await page.$$(".steps li")).length, 8, "the last picture stays");
        second = await start(demo, ...MID_PLAN, "--port", first.port);
        await says("another run");
        await page.goto(second.url);
        await says("Live");
      });
    } finally {
      await first.stop();
      await second?.stop();
    }
  });

  it("lets nobody in without the token", async () => {
    await onPage(`http://127.0.0.1:${studio.port}/?token=guess`, DESKTOP, async (page) => {
      assert.match(await page.textContent("h1"), /Open the address/);
    });
  });
});

/** How many different colours the picture has. */
async function coloursOf(page) {
  const picture = await page.locator("canvas").screenshot();
  return page.evaluate(async (bytes) => {
    const bitmap = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }, [...picture]);
}
