import { describe, expect, it } from "vitest";

import type { PlanStep } from "./protocol";
import { clockText, connectionText, speedText, stepTitle } from "./text";

const step: PlanStep = {
  index: 0,
  kind: "manipulate",
  action: "throw_away",
  args: ["green-bottle"],
  state: "pending",
  attempts: 0,
  reason: "",
};

describe("words", () => {
  it("read as a person would say them", () => {
    expect(stepTitle(step)).toBe("throw away green bottle");
    expect(clockText(0)).toBe("0:00");
    expect(clockText(59.99)).toBe("0:59");
    expect(clockText(3725)).toBe("62:05");
    expect(clockText(-1)).toBe("0:00");
    expect(speedText(2.345)).toBe("2.3×");
    expect(speedText(9.96)).toBe("10×");
  });

  it("tell a connection that broke from a run that has ended", () => {
    const lost = { kind: "lost", retryInSecs: 2 } as const;
    expect(connectionText(lost, false)).toContain("trying again in 2 s");
    expect(connectionText(lost, true)).toContain("has ended");
  });
});
