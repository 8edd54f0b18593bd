// Skills that are being learned, or were: a row for each with its learning curve, and its figures on demand.

import { drawing, element, icon } from "../dom";
import { heightOf, learningCurve, lineThrough, type Mark, round, SHEET } from "../learning_curve";
import type { Evaluation, Training } from "../protocol";
import type { Store } from "../store";
import {
  curveText,
  episodesText,
  FIGURE_HEADS,
  figureTexts,
  percentText,
  practiceText,
  TEXT,
  trainingText,
} from "../text";

/** Half the side of a mark. */
const MARK = 2.5;

export function learnPanel(store: Store): HTMLElement {
  const list = element("ul", { class: "trainings" });
  const panel = element(
    "section",
    { class: "panel learn", "aria-labelledby": "learn-title" },
    element("header", {}, element("h2", { id: "learn-title" }, TEXT.learn), key()),
    element("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": TEXT.learn }, list),
  );

  // Rows stay the same elements, so that one that is open or has the focus keeps it while the figures change.
  let rows = new Map<string, Row>();
  store.watch(["trainings"], () => {
    const trainings = store.get("trainings");
    const before = rows;
    rows = new Map(trainings.map(({ name }) => [name, before.get(name) ?? new Row(name)]));
    for (const training of trainings) {
      rows.get(training.name)?.show(training);
    }
    const items = [...rows.values()].map(({ item }) => item);
    if (items.length !== list.children.length || items.some((item, at) => item !== list.children[at])) {
      list.replaceChildren(...items);
    }
    panel.hidden = trainings.length === 0;
  });
  return panel;
}

/** One training. */
class Row {
  readonly item: HTMLElement;
  private readonly what = element("span", { class: "aside" });
  private readonly state = element("span", { class: "state" });
  private readonly practice = element("p", { class: "aside" });
  private readonly curve = drawing("svg", {
    viewBox: `0 0 ${SHEET.width} ${SHEET.height}`,
    role: "img",
    class: "curve",
  });
  private readonly table = element("tbody");
  private readonly figures: HTMLDetailsElement;
  private shown = "";
  private evaluations: readonly Evaluation[] = [];

  constructor(name: string) {
    const heads = FIGURE_HEADS.map((head) => element("th", { scope: "col" }, head));
    this.figures = element(
      "details",
      {},
      element("summary", {}, TEXT.figures, element("span", { class: "spoken" }, ` ${name}`)),
      element("table", {}, element("thead", {}, element("tr", {}, ...heads)), this.table),
    );
    this.figures.addEventListener("toggle", () => this.fillTable());
    this.item = element(
      "li",
      {},
      element("div", { class: "head" }, element("h3", {}, name), this.state),
      this.what,
      this.curve,
      this.practice,
      this.figures,
    );
  }

  show(training: Training): void {
    const text = JSON.stringify(training);
    if (text === this.shown) {
      return;
    }
    this.shown = text;
    this.evaluations = training.evaluations;
    this.what.textContent = trainingText(training);
    this.state.replaceChildren(
      icon(training.running ? "running" : "pause"),
      training.running ? TEXT.learning : TEXT.atRest,
    );
    this.item.dataset["running"] = String(training.running);
    this.practice.textContent = practiceText(training);
    this.curve.setAttribute("aria-label", curveText(training.evaluations));
    this.curve.replaceChildren(...drawn(training));
    this.figures.hidden = training.evaluations.length === 0;
    this.fillTable();
  }

  /** The figures are only made for who looks at them. */
  private fillTable(): void {
    const evaluations = this.figures.open ? this.evaluations : [];
    this.table.replaceChildren(
      ...evaluations.map((evaluation) =>
        element("tr", {}, ...figureTexts(evaluation).map((text) => element("td", {}, text))),
      ),
    );
  }
}

/** What the lines mean. */
function key(): HTMLElement {
  const sample = (kind: Kind, word: string): HTMLElement =>
    element(
      "span",
      {},
      drawing(
        "svg",
        { viewBox: "0 0 32 10", "aria-hidden": "true", class: "sample" },
        drawing("path", { d: "M0 5H32", class: kind }),
        dot(kind, { x: 16, y: 5 }),
      ),
      word,
    );
  return element(
    "span",
    { class: "aside key" },
    sample("success", TEXT.success),
    sample("violation", TEXT.violation),
  );
}

type Kind = "success" | "violation";

/** Round marks for success, square ones for violations: without colour too, and when there is but one. */
function dot(kind: Kind, { x, y }: Mark): SVGElement {
  return kind === "success"
    ? drawing("circle", { cx: round(x), cy: round(y), r: String(MARK), class: kind })
    : drawing("rect", {
        x: round(x - MARK),
        y: round(y - MARK),
        width: String(2 * MARK),
        height: String(2 * MARK),
        class: kind,
      });
}

function drawn(training: Training): SVGElement[] {
  const curve = learningCurve(training.episodes, training.evaluations);
  const line = (kind: Kind): SVGElement[] => [
    drawing("path", { d: lineThrough(curve[kind]), class: kind }),
    ...curve[kind].map((mark) => dot(kind, mark)),
  ];
  return [...axes(curve.episodes), ...line("violation"), ...line("success")];
}

function axes(episodes: number): SVGElement[] {
  const { left, right, bottom, height } = SHEET;
  const levels = [0, 0.5, 1].flatMap((rate) => {
    const y = heightOf(rate);
    const d = lineThrough([{ x: left, y }, { x: right, y }]);
    return [
      drawing("path", { d, class: "level" }),
      drawing("text", { x: String(left - 6), y: String(y + 4), class: "end" }, percentText(rate)),
    ];
  });
  const under = String(height - 4);
  return [
    ...levels,
    drawing("text", { x: String(left), y: under }, "0"),
    drawing("text", { x: String(right), y: under, class: "end" }, episodesText(episodes)),
    drawing("path", { d: `M${left} ${bottom}v4M${right} ${bottom}v4`, class: "level" }),
  ];
}
