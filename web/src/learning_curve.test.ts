import { describe, expect, it } from "vitest";

import { heightOf, learningCurve, lineThrough, SHEET } from "./learning_curve";
import type { Evaluation } from "./protocol";

function evaluation(episode: number, success_rate: number, violation_rate: number): Evaluation {
  return { episode, success_rate, violation_rate, peak_force_n: 60, time_to_success_secs: null };
}

describe("a learning curve", () => {
  it("has a mark for each evaluation, from the axis to its end and from 0 to 100 %", () => {
    const curve = learningCurve(40, [evaluation(0, 0, 1), evaluation(20, 0.5, 0.25), evaluation(40, 1, 0)]);
    expect(curve.episodes).toBe(40);
    expect(curve.success).toEqual([
      { x: SHEET.left, y: SHEET.bottom },
      { x: (SHEET.left + SHEET.right) / 2, y: (SHEET.bottom + SHEET.top) / 2 },
      { x: SHEET.right, y: SHEET.top },
    ]);
    expect(curve.violation.map(({ x }) => x)).toEqual(curve.success.map(({ x }) => x));
    expect(curve.violation.map(({ y }) => y)).toEqual([SHEET.top, heightOf(0.25), SHEET.bottom]);
  });

  it("leaves room for the episodes that come after its last mark", () => {
    expect(learningCurve(0, []).episodes).toBe(10);
    expect(learningCurve(80, [evaluation(40, 1, 0)]).success[0]?.x).toBe((SHEET.left + SHEET.right) / 2);
    expect(learningCurve(30, [evaluation(40, 1, 0)]).success[0]?.x).toBe(SHEET.right);
  });

  it("stays on its sheet whatever the rates are", () => {
    expect(heightOf(-1)).toBe(SHEET.bottom);
    expect(heightOf(7)).toBe(SHEET.top);
  });

  it("is a line through its marks", () => {
    expect(lineThrough([])).toBe("");
    expect(lineThrough([{ x: 1, y: 2 }])).toBe("M1 2");
    expect(lineThrough([{ x: 1, y: 2 }, { x: 3.456, y: 4 }])).toBe("M1 2L3.5 4");
  });
});
