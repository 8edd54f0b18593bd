// Builds and starts the programs that serve the page.

import { execFileSync, spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

export const REPOSITORY = fileURLToPath(new URL("../..", import.meta.url));

/** The studio's demo, which tells the page a story without any physics. */
export const DEMO = { name: "demo", options: ["--package", "factotum-studio", "--example", "demo"] };

/** Factotum itself. */
export const FACTOTUM = { name: "factotum", options: ["--package", "factotum-cli", "--bin", "factotum"] };

/** Path of the built program, or null where there is no cargo. */
export function build({ name, options }) {
  let output;
  try {
    output = execFileSync("cargo", ["build", ...options, "--message-format", "json"], {
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
    .findLast((message) => message.executable && message.target.name === name);
  return built.executable;
}

/** Starts a program; resolves when it has said where it serves. */
export async function start(executable, ...options) {
  const child = spawn(executable, options, { cwd: REPOSITORY, stdio: ["ignore", "pipe", "pipe"] });
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const said = [];
  const url = await new Promise((resolve, reject) => {
    for (const stream of [child.stdout, child.stderr]) {
      createInterface({ input: stream }).on("line", (line) => {
        said.push(line);
        const address = /http:\S+/.exec(line);
        if (address !== null) {
          resolve(address[0]);
        }
      });
    }
    child.once("error", reject);
    child.once("close", () => reject(new Error(`it ended before it served: ${said.join("\n")}`)));
  });
  return {
    url,
    port: new URL(url).port,
    async stop() {
      child.kill();
      await ended;
    },
  };
}
