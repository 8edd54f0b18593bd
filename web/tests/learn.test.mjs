// Skills that are learned elsewhere, on the page of a stored home: Factotum's own studio over skill folders that grow.
//
// Skips, and says how to get what is missing, where there is no Chromium or no cargo.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { appendFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";

import { findChromium, HOW_TO_GET_IT, launch } from "./chromium.mjs";
import { DESKTOP, onPage, overflowOf, PHONE } from "./on_page.mjs";
import { build, FACTOTUM, REPOSITORY, start } from "./program.mjs";

const executablePath = findChromium();
const factotum = executablePath === null ? null : build(FACTOTUM);
const skip =
  (executablePath === null && HOW_TO_GET_IT) || (factotum === null && "no cargo to build Factotum with");

describe("the panel of what is learned", { skip, concurrency: false }, () => {
  let browser;
  let dir;
  let skills;
  let studio;

  before(async () => {
    browser = await launch(executablePath);
    dir = mkdtempSync(join(tmpdir(), "factotum-learn-"));
    skills = join(dir, "skills");
    const home = join(dir, "home");
    writeFileSync(join(dir, "room.pgm"), Buffer.concat([Buffer.from("P5\n4 4\n255\n"), Buffer.alloc(16, 254)]));
    writeFileSync(
      join(dir, "room.yaml"),
      "image: room.pgm\nresolution: 1.0\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    );
    execFileSync(factotum, ["map", "import", join(dir, "room.yaml"), "--out", home]);
    studio = await start(factotum, "studio", "--home", home, "--skills", skills);
  });

  after(async () => {
    await studio?.stop();
    await browser?.close();
    rmSync(dir, { recursive: true, force: true });
  });

  it("appears with a training of another process, and shows its figures as they come", async () => {
    await onPage(browser, studio.url, DESKTOP, async (page) => {
      await page.locator(".connection", { hasText: "Live" }).waitFor();
      assert.equal(await page.locator(".learn").isVisible(), false, "there is no folder yet");

      const folder = join(skills, "my-door");
      const learned = train(folder, 1);
      const row = page.locator(".trainings > li", { hasText: "my-door" });
      await row.waitFor();
      assert.match(await row.textContent(), /door · unstructured · seed 3/);
      await row.locator("p", { hasText: /^1 episode · / }).waitFor();
      assert.equal(await learned, 0, "the training has ended well");
      await curve(row, "Learning curve of 1 evaluation. After 1 episode:").waitFor();

      append(folder, episode(2, true), episode(3, true), evaluation(3, 0.8, 0.1));
      await row.locator("p", { hasText: /^3 episodes · 60 steps · / }).waitFor();
      await curve(row, "After 3 episodes: success 80 %, near a joint limit 10 %.").waitFor();
      await row.locator(".state", { hasText: "learning" }).waitFor();
      assert.equal(await row.locator("circle.success").count(), 2);
      assert.equal(await row.locator("rect.violation").count(), 2);
      await row.locator(".state", { hasText: "at rest" }).waitFor();
    });
  });

  it("opens its table by keys, and keeps it open while it grows", async () => {
    await onPage(browser, studio.url, DESKTOP, async (page) => {
      const row = page.locator(".trainings > li", { hasText: "my-door" });
      await row.locator("summary").focus();
      await page.keyboard.press("Enter");
      const last = row.locator("tbody tr").last();
      await last.getByText("80 %").waitFor();
      append(join(skills, "my-door"), episode(4, true), evaluation(4, 1, 0));
      await last.getByText("100 %").waitFor();
      assert.deepEqual(await last.locator("td").allTextContents(), ["4", "100 %", "0 %", "61 N", "1.5 s"]);
      assert.equal(await row.locator("summary").evaluate((one) => one === document.activeElement), true);
    });
  });

  it("fits a phone without scrolling sideways", async () => {
    await onPage(browser, studio.url, PHONE, async (page) => {
      const summary = page.locator(".trainings summary").first();
      await summary.tap();
      await page.locator(".trainings tbody td").first().waitFor();
      const overflow = await overflowOf(page);
      assert.ok(overflow <= 0, `${overflow} pixels too wide`);
      assert.ok((await summary.boundingBox()).height >= 44, "a finger hits it");
    });
  });

  it("tells of a folder that it cannot read, and goes on", async () => {
    await onPage(browser, studio.url, DESKTOP, async (page) => {
      mkdirSync(join(skills, "broken"));
      writeFileSync(join(skills, "broken", "skill.toml"), "format = 9\n");
      const told = page.locator(".events li[data-level='warning']", { hasText: "broken" });
      await told.waitFor();
      const folder = join(skills, "my-door");
      append(folder, episode(5, false));
      await page.locator(".trainings p", { hasText: /^5 episodes · / }).waitFor();
      assert.equal(await told.count(), 1);
      assert.equal(await page.locator(".trainings > li").count(), 1);
    });
  });
});

/** Learns for some episodes in a process of its own; resolves to its exit code. */
function train(folder, episodes) {
  const learn = ["skill", "train", "door", "--ablation", "unstructured", "--seed", "3"];
  const child = spawn(factotum, [...learn, "--episodes", String(episodes), "--out", folder, "--quiet"], {
    cwd: REPOSITORY,
    stdio: ["ignore", "ignore", "inherit"],
  });
  return new Promise((resolve) => child.once("exit", resolve));
}

/** The curve in a row, as a screen reader tells of it. */
function curve(row, text) {
  return row.getByRole("img", { name: text });
}

function append(folder, ...lines) {
  appendFileSync(join(folder, "metrics.jsonl"), lines.map((line) => `${JSON.stringify(line)}\n`).join(""));
}

function episode(number, success) {
  const felt = { steps: 20, peak_force_n: 60.5, grasp: null, failure: null };
  return { episode: number, env_steps: 20 * number, success, violation: false, ...felt };
}

function evaluation(number, success_rate, violation_rate) {
  const felt = { rollouts: 10, peak_force_n: 61.2, time_to_success_secs: 1.5 };
  return { episode: number, env_steps: 20 * number, success_rate, violation_rate, ...felt };
}
