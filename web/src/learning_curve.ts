// Where the marks of a learning curve lie: rates from 0 to 100 % over training episodes.

import type { Evaluation } from "./protocol";

/** The sheet that it is drawn on, and the edges of the plot on it. */
export const SHEET = { width: 320, height: 110, left: 44, right: 312, top: 8, bottom: 90 } as const;

/** The fewest episodes that the axis spans, so that a first mark does not lie at its end. */
const EPISODES_MIN = 10;

export interface Mark {
  readonly x: number;
  readonly y: number;
}

export interface LearningCurve {
  /** Episodes at the end of the axis. */
  readonly episodes: number;
  readonly success: readonly Mark[];
  readonly violation: readonly Mark[];
}

/** The curve of a training that has lived through so many episodes. */
export function learningCurve(episodes: number, evaluations: readonly Evaluation[]): LearningCurve {
  const end = Math.max(EPISODES_MIN, episodes, ...evaluations.map(({ episode }) => episode));
  const mark = (episode: number, rate: number): Mark => ({
    x: SHEET.left + ((SHEET.right - SHEET.left) * episode) / end,
    y: heightOf(rate),
  });
  return {
    episodes: end,
    success: evaluations.map((one) => mark(one.episode, one.success_rate)),
    violation: evaluations.map((one) => mark(one.episode, one.violation_rate)),
  };
}

/** Where a rate lies on the sheet; what is no rate lies at the nearest end of the axis. */
export function heightOf(rate: number): number {
  const share = Math.min(1, Math.max(0, rate));
  return SHEET.bottom - (SHEET.bottom - SHEET.top) * share;
}

/** The line through the marks, as the `d` of an SVG path. */
export function lineThrough(marks: readonly Mark[]): string {
  return marks.map(({ x, y }, index) => `${index === 0 ? "M" : "L"}${round(x)} ${round(y)}`).join("");
}

/** A tenth of a unit of the sheet is less than a pixel. */
export function round(length: number): string {
  return String(Math.round(10 * length) / 10);
}
