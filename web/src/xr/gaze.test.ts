import { describe, expect, it } from "vitest";

import { lookedAtFrom } from "./gaze";

const close = (a: readonly number[], b: readonly number[]): void =>
  a.forEach((value, index) => expect(value).toBeCloseTo(b[index] ?? Number.NaN));

describe("where a person looks", () => {
  it("is where the gaze meets the floor, as far as a thing may be put down", () => {
    close(lookedAtFrom([1, 2, 1.6], [0, 0.6, -0.8]), [1, 3.2]);
    close(lookedAtFrom([1, 2, 1.6], [0.9, 0, -0.1]), [2.5, 2]);
    close(lookedAtFrom([1, 2, 1.6], [0, 0.1, -0.9]), [1, 2.5]);
  });

  it("is ahead for who looks up, and at the feet for who looks straight down", () => {
    close(lookedAtFrom([0, 0, 1.6], [0, -1, 0.5]), [0, -1.5]);
    close(lookedAtFrom([3, 4, 1.6], [0, 0, -1]), [3, 4]);
  });
});
