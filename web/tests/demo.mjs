// Builds and starts the studio's demo, which tells the page a story without any physics.

import { execFileSync, spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const REPOSITORY = fileURLToPath(new URL("../..", import.meta.url));
const BUILD = ["build", "--package", "factotum-studio", "--example", "demo", "--message-format", "json"];

/** Path of the built demo, or null where there is no cargo. */
export function buildDemo() {
  let output;
  try {
    output = execFileSync("cargo", BUILD, {
      cwd: REPOSITORY,
      encoding: "utf8",
      maxBuffer: 64 << 20,
      stdio: ["ignore", "pipe", "inherit"],
    });
  } catch (error) {
    if (error.code === "ENOENT") {
      return null;
    }
    throw error;
  }
  const built = output
    .split("\n")
    .filter((line) => line.startsWith("{"))
    .map((line) => JSON.parse(line))
    .findLast((message) => message.executable && message.target.name === "demo");
  return built.executable;
}

/** Starts the demo; resolves when it serves. */
export async function startDemo(executable, ...options) {
  const child = spawn(executable, options, { stdio: ["ignore", "pipe", "inherit"] });
  const ended = new Promise((resolve) => child.once("exit", resolve));
  for await (const url of createInterface({ input: child.stdout })) {
    return {
      url,
      port: new URL(url).port,
      async stop() {
        child.kill();
        await ended;
      },
    };
  }
  throw new Error("the demo ended before it served");
}
