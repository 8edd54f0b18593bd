// Saves pictures of a running studio page.
//
//   node tests/screenshot.mjs URL OUT.png [--dark] [--wait SECS] [--keys KEYS]
//
// Writes OUT.png at 1280x800 and OUT-phone.png at the size of a phone. URL is the one that the
// studio printed. KEYS are pressed first, such as `f` to follow the robot.

import { parseArgs } from "node:util";

import { findChromium, HOW_TO_GET_IT, launch, untilDrawn } from "./chromium.mjs";

const SIZES = [
  { suffix: "", viewport: { width: 1280, height: 800 } },
  { suffix: "-phone", viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true },
];

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    dark: { type: "boolean", default: false },
    wait: { type: "string", default: "0" },
    keys: { type: "string", default: "" },
  },
});
const [url, out] = positionals;
if (url === undefined || !out?.endsWith(".png")) {
  console.error("usage: node tests/screenshot.mjs URL OUT.png [--dark] [--wait SECS] [--keys KEYS]");
  process.exit(2);
}
const executablePath = findChromium();
if (executablePath === null) {
  console.error(HOW_TO_GET_IT);
  process.exit(1);
}

const browser = await launch(executablePath);
try {
  for (const { suffix, ...device } of SIZES) {
    const context = await browser.newContext({
      ...device,
      colorScheme: values.dark ? "dark" : "light",
    });
    const page = await context.newPage();
    page.on("console", (message) => {
      if (message.type() === "error" || message.type() === "warning") {
        console.error(`page: ${message.text()}`);
      }
    });
    page.on("pageerror", (error) => console.error(`page: ${error.message}`));
    await page.goto(`${url}#sharp`);
    await untilDrawn(page);
    for (const key of values.keys) {
      await page.keyboard.press(key);
    }
    await page.waitForTimeout(1000 * Number(values.wait));
    const path = out.replace(/\.png$/, `${suffix}.png`);
    await page.screenshot({ path });
    console.log(path);
    await context.close();
  }
} finally {
  await browser.close();
}
