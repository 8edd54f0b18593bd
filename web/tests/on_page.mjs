// Looking at the page on some device.

import assert from "node:assert/strict";

export const DESKTOP = { viewport: { width: 1280, height: 800 } };
export const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
/** Few pixels, for what asks the page many things while it draws. */
export const SMALL = { viewport: { width: 800, height: 480 } };

/** Runs `look` on a page of its own, on which nothing may go wrong; `prepare` comes before the page is opened. */
export async function onPage(browser, url, device, look, prepare = async () => {}) {
  const context = await browser.newContext(device);
  const page = await context.newPage();
  const problems = [];
  page.on("pageerror", (error) => problems.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error" && !isExpected(message.text())) {
      problems.push(message.text());
    }
  });
  // The picture is drawn by the processor here; on a busy machine that takes its time.
  page.setDefaultTimeout(120_000);
  try {
    await prepare(page);
    await page.goto(url);
    await look(page);
  } finally {
    await context.close();
  }
  assert.deepEqual(problems, []);
}

/** A browser reports every failed connection as an error; losing one is tested here. */
function isExpected(text) {
  return /WebSocket connection|net::ERR_CONNECTION_REFUSED|401/.test(text);
}

/** How far the page is wider than its window, in pixels. */
export function overflowOf(page) {
  return page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
}
