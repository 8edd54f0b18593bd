// Teaching a home of which nothing is known but its map: Factotum's own studio, the page, a mouse and keys.
//
// Skips, and says how to get what is missing, where there is no Chromium or no cargo. With FACTOTUM_PICTURES naming a
// folder, pictures of the steps are left there.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";

import { findChromium, HOW_TO_GET_IT, launch } from "./chromium.mjs";
import { emptyHome } from "./empty_home.mjs";
import { DESKTOP, onPage, overflowOf, PHONE, SMALL } from "./on_page.mjs";
import { build, FACTOTUM, start } from "./program.mjs";

const executablePath = findChromium();
const factotum = executablePath === null ? null : build(FACTOTUM);
const skip =
  (executablePath === null && HOW_TO_GET_IT) || (factotum === null && "no cargo to build Factotum with");

describe("teaching", { skip, concurrency: false }, () => {
  let browser;
  let dir;
  let home;
  let studio;

  before(async () => {
    browser = await launch(executablePath);
    dir = mkdtempSync(join(tmpdir(), "factotum-teach-"));
    home = emptyHome(factotum, dir);
    studio = await start(factotum, "studio", "--home", home, "--skills", join(dir, "skills"));
  });

  after(async () => {
    await studio?.stop();
    await browser?.close();
    rmSync(dir, { recursive: true, force: true });
  });

  it("makes kinds of things, places them, and shows how to hold one and what to do with it", async () => {
    await onPage(browser, studio.url, DESKTOP, async (page) => {
      const teach = page.getByRole("region", { name: "Teach", exact: true });
      await at(teach, "Your home");
      assert.equal(await teach.getByRole("button", { name: "Undo" }).isDisabled(), true);

      await make(teach, { name: "Basket", shape: "box", movable: false });
      await at(teach, "Where is basket 1?");
      await teach.getByLabel("Height, cm").fill("35");
      await page.keyboard.press("Tab");
      await teach.getByRole("button", { name: "Back" }).click();

      await make(teach, { name: "Green bottle", shape: "cylinder", movable: true });
      await at(teach, "Where is green bottle 1?");
      await drag(page, teach);
      await write(page, teach, "x", "-80");
      await picture(page, "teach-where");
      await teach.getByRole("button", { name: "Next" }).click();

      await at(teach, "How is a green bottle held?");
      await teach.getByRole("button", { name: "Show a way to hold it" }).click();
      await at(teach, "Hold the green bottle");
      await teach.getByLabel("Opening, cm").fill("9");
      await page.keyboard.press("Tab");
      await picture(page, "teach-hold");
      await teach.getByRole("button", { name: "Save" }).click();
      await at(teach, "How is a green bottle held?");
      await teach.getByText("side", { exact: true }).waitFor();
      await teach.getByRole("button", { name: "Next" }).click();

      await at(teach, "What can be done with a green bottle?");
      await teach.getByRole("button", { name: "Put it into something" }).click();
      await at(teach, "Do something with a green bottle");
      await teach.getByLabel("Name").fill("throw away");
      await picture(page, "teach-do");
      await teach.getByRole("button", { name: "Save" }).click();
      await at(teach, "What can be done with a green bottle?");
      await teach.getByText("throw away", { exact: true }).waitFor();
      await teach.getByText("into basket").waitFor();

      // The robot can plan with it: it has places to stand for the new action.
      await page.locator(".regions li", { hasText: "throw away" }).waitFor();
      await picture(page, "teach-done");
      await teach.getByRole("button", { name: "Finish" }).click();
      await at(teach, "Your home");
    });
    const check = execFileSync(factotum, ["home", "show", home, "--json"], { encoding: "utf8" });
    assert.deepEqual(JSON.parse(check).options, [
      "(pick green_bottle_1)",
      "(throw_away green_bottle_1 basket_1)",
    ]);
  });

  it("keeps it over a reload, shows it to a second page, and undoes it for both", async () => {
    await onPage(browser, studio.url, SMALL, async (page) => {
      const other = await page.context().newPage();
      await other.goto(page.url());
      const lists = [page, other].map((one) => one.getByRole("region", { name: "Teach", exact: true }));
      for (const teach of lists) {
        await teach.getByRole("button", { name: "Change green bottle 1" }).click();
        assert.equal(await valueOf(teach, "z"), 0);
        await teach.getByRole("button", { name: "Next" }).click();
        await teach.getByText("side", { exact: true }).waitFor();
        await teach.getByRole("button", { name: "Next" }).click();
        await teach.getByText("throw away", { exact: true }).waitFor();
      }
      const [teach, watching] = lists;
      const undo = teach.getByRole("button", { name: "Undo" });
      assert.equal(await undo.getAttribute("title"), "Undo: teach throw_away of green_bottle");
      await undo.click();
      for (const one of lists) {
        await one.getByText("throw away", { exact: true }).waitFor({ state: "detached" });
        await one.getByText("Nothing yet.").waitFor();
      }
      await watching.getByRole("button", { name: "Do again" }).click();
      for (const one of lists) {
        await one.getByText("throw away", { exact: true }).waitFor();
      }
    });
  });

  it("says why an edit is refused, and changes nothing", async () => {
    await onPage(browser, studio.url, SMALL, async (page) => {
      const teach = page.getByRole("region", { name: "Teach", exact: true });
      await make(teach, { name: "Basket", shape: "box", movable: false });
      const refusal = teach.getByRole("alert");
      await refusal.getByText("a class is named `basket` already, expected a new name").waitFor();
      await at(teach, "What is it?");

      await teach.getByRole("button", { name: "Back" }).click();
      await teach.getByRole("button", { name: "Change green bottle 1" }).click();
      await teach.getByLabel("The robot can carry it").click();
      await refusal.getByText("not movable").waitFor();
      assert.equal(await teach.getByLabel("The robot can carry it").isChecked(), true, "it shows what is so");
    });
  });

  it("gives a thing another name, and forgets a kind of which there is nothing", async () => {
    await onPage(browser, studio.url, SMALL, async (page) => {
      const teach = page.getByRole("region", { name: "Teach", exact: true });
      await make(teach, { name: "Spare", shape: "box", movable: false });
      await at(teach, "Where is spare 1?");
      await teach.getByLabel("Name").fill("Odd one");
      await teach.getByRole("button", { name: "Rename" }).click();
      await at(teach, "Where is odd one?");
      await teach.getByRole("button", { name: "Take it out of the map" }).click();
      await at(teach, "Your home");
      await teach.getByRole("button", { name: "Teach a new thing" }).click();
      await teach.getByRole("button", { name: "Forget spare" }).click();
      await teach.getByRole("button", { name: "spare", exact: true }).waitFor({ state: "detached" });
      assert.equal(await teach.getByRole("button", { name: "Forget basket" }).count(), 0, "there is a basket");
    });
  });

  it("teaches by keys alone how a part of a thing is moved", async () => {
    await onPage(browser, studio.url, SMALL, async (page) => {
      const teach = page.getByRole("region", { name: "Teach", exact: true });
      const press = async (name) => {
        await teach.getByRole("button", { name, exact: true }).focus();
        await page.keyboard.press("Enter");
      };
      await press("Teach a new thing");
      await at(teach, "What is it?");
      await teach.getByLabel("Name").focus();
      await page.keyboard.type("fmrls");
      assert.equal(await teach.getByLabel("Name").inputValue(), "fmrls", "letters are letters in a name");
      assert.equal(await page.getByRole("button", { name: "Labels" }).getAttribute("aria-pressed"), "true");

      await press("faucet");
      await at(teach, "Where is faucet 1?");
      await press("Next");
      await at(teach, "How is a faucet held?");
      await press("Next");
      await at(teach, "What can be done with a faucet?");
      await press("Move a part of it");
      await at(teach, "Do something with a faucet");
      await teach.getByLabel("Name").focus();
      await page.keyboard.type("half open");
      assert.equal(await teach.getByLabel("Then it is").inputValue(), "open", "as it is called at the joint's end");
      await teach.getByRole("spinbutton", { name: "Ends at" }).focus();
      await page.keyboard.press("Control+A");
      await page.keyboard.type("20");
      await page.keyboard.press("Tab");
      const effect = teach.getByLabel("Then it is");
      assert.equal(await effect.inputValue(), "", "there is no name yet for what it is there");
      await effect.focus();
      await page.keyboard.type("dripping");
      await picture(page, "teach-joint");
      await press("Save");
      await at(teach, "What can be done with a faucet?");
      await teach.getByText("handle: dripping").waitFor();
    });
  });

  it("fits a phone without scrolling sideways", async () => {
    await onPage(browser, studio.url, PHONE, async (page) => {
      const teach = page.getByRole("region", { name: "Teach", exact: true });
      await teach.getByRole("button", { name: "Change green bottle 1" }).tap();
      await at(teach, "Where is green bottle 1?");
      const overflow = await overflowOf(page);
      assert.ok(overflow <= 0, `${overflow} pixels too wide`);
      const box = await teach.getByRole("button", { name: "Next" }).boundingBox();
      assert.ok(box.height >= 44, "a finger hits it");
      await picture(page, "teach-phone");
    });
  });
});

/** Waits until a step is shown. */
function at(teach, title) {
  return teach.getByRole("heading", { name: title }).waitFor();
}

async function make(teach, { name, shape, movable }) {
  await teach.getByRole("button", { name: "Teach a new thing" }).click();
  await teach.getByLabel("Name").fill(name);
  await teach.getByLabel("Shape").selectOption(shape);
  await teach.getByLabel("The robot can carry it").setChecked(movable);
  await teach.getByRole("button", { name: "Make it" }).click();
}

function field(teach, label) {
  return teach.getByRole("spinbutton", { name: label, exact: true });
}

async function valueOf(teach, label) {
  return Number(await field(teach, label).inputValue());
}

async function write(page, teach, label, text) {
  await field(teach, label).fill(text);
  await page.keyboard.press("Tab");
  await saved(teach);
}

/** Waits until all edits are answered. */
function saved(teach) {
  return teach.getByText("Saving").waitFor({ state: "detached" });
}

/** Drags the thing by the middle of its gizmo, which is where the camera looks, and sees that it went there for good. */
async function drag(page, teach) {
  const before = [await valueOf(teach, "x"), await valueOf(teach, "y")];
  const stage = await page.locator("#stage").boundingBox();
  const [x, y] = [stage.x + stage.width / 2, stage.y + stage.height / 2 - 24];
  await page.mouse.move(x, y);
  await page.waitForTimeout(300);
  await page.mouse.down();
  await page.mouse.move(x + 40, y, { steps: 4 });
  await page.mouse.move(x + 120, y + 10, { steps: 4 });
  await page.waitForTimeout(300);
  await page.mouse.up();
  await saved(teach);
  const now = [await valueOf(teach, "x"), await valueOf(teach, "y")];
  assert.ok(Math.hypot(now[0] - before[0], now[1] - before[1]) > 5, `${before} cm to ${now} cm`);
  for (const at of now) {
    assert.ok(Math.abs(at / 5 - Math.round(at / 5)) < 1e-3, `${at} cm is on the grid`);
  }
  await teach.getByRole("button", { name: "Put it on the floor" }).click();
  await saved(teach);
}

async function picture(page, name) {
  const folder = process.env.FACTOTUM_PICTURES;
  if (folder !== undefined) {
    await page.waitForTimeout(1500);
    await page.screenshot({ path: join(folder, `${name}.png`) });
  }
}
