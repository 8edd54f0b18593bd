import { describe, expect, it } from "vitest";

import type { Evaluation, PlanStep, Training } from "./protocol";
import {
  clockText,
  connectionText,
  curveText,
  figureTexts,
  practiceText,
  speedText,
  stepTitle,
  trainingText,
} from "./text";

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
    const free = { role: "execute", isOwned: false } as const;
    expect(connectionText(lost, false, free)).toContain("trying again in 2 s");
    expect(connectionText(lost, true, free)).toContain("has ended");
  });

  it("say what the page may do and that another has the robot", () => {
    const open = { kind: "open" } as const;
    expect(connectionText(open, false, { role: "execute", isOwned: false })).toBe("Live");
    expect(connectionText(open, false, { role: "view", isOwned: false })).toContain("look");
    expect(connectionText(open, false, { role: "execute", isOwned: true })).toContain("another page has the robot");
  });
});

describe("the figures of a training", () => {
  const evaluation: Evaluation = {
    episode: 10,
    success_rate: 0.9,
    violation_rate: 0.1,
    peak_force_n: 61.7,
    time_to_success_secs: null,
  };
  const training: Training = {
    name: "night",
    task: "my_door",
    ablation: "hard-guard",
    seed: "7",
    running: true,
    episodes: 24,
    env_steps: 812,
    violations: 3,
    recent_success_rate: 0.85,
    evaluations: [evaluation],
  };

  it("say what is learned and how far", () => {
    expect(trainingText(training)).toBe("my door · hard-guard · seed 7");
    expect(practiceText(training)).toBe(
      "24 episodes · 812 steps · 85 % success in the last 20 · 3 near a joint limit",
    );
    expect(practiceText({ ...training, episodes: 1, recent_success_rate: 1, violations: 0 })).toBe(
      "1 episode · 812 steps · 100 % success in the last 1 · 0 near a joint limit",
    );
    expect(practiceText({ ...training, episodes: 0, recent_success_rate: null })).not.toContain("success");
  });

  it("are told without the picture", () => {
    expect(curveText([])).toContain("Not evaluated yet");
    expect(curveText([evaluation])).toContain("Learning curve of 1 evaluation. After 10 episodes:");
    const worse = { ...evaluation, episode: 20, success_rate: 0.405, violation_rate: 0 };
    expect(curveText([evaluation, worse])).toBe(
      "Learning curve of 2 evaluations. After 20 episodes: success 41 %, near a joint limit 0 %. Best success: 90 %.",
    );
    expect(figureTexts(evaluation)).toEqual(["10", "90 %", "10 %", "62 N", "–"]);
    expect(figureTexts({ ...evaluation, time_to_success_secs: 1.5 }).at(-1)).toBe("1.5 s");
  });
});
