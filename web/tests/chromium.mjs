// Finding and starting a browser for tests and screenshots.

import { accessSync, constants } from "node:fs";

import { chromium } from "playwright-core";

/** Software rendering and no traffic of its own, so that it runs on any machine, offline. */
const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

export const HOW_TO_GET_IT =
  "no Chromium found; install it with `apt-get install chromium`, or name one in CHROMIUM";

/** Path of the browser, or null. */
export function findChromium() {
  for (const path of [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser"]) {
    try {
      accessSync(path ?? "", constants.X_OK);
      return path;
    } catch {
      // The next one, then.
    }
  }
  return null;
}

export function launch(executablePath) {
  return chromium.launch({ executablePath, args: FLAGS });
}

/** Waits until the page has drawn bodies, and the walls between it and them have gone down. */
export async function untilDrawn(page, timeout = 30_000) {
  await page.waitForSelector("#stage[data-bodies]:not([data-bodies='0'])", { timeout });
  await page.waitForTimeout(1500);
}
