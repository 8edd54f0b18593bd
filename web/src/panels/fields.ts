// Labelled inputs that follow a value until a person writes into them.

import { element } from "../dom";

export interface Field<T> {
  readonly node: HTMLElement;
  /** Shows a value, unless it is just being written. */
  show(value: T): void;
}

type Changed<T> = (value: T) => void;

/** How a number is written: metres as centimetres, radians as degrees. */
export const CM = { scale: 100, step: "0.1" } as const;
export const DEGREES = { scale: 180 / Math.PI, step: "1" } as const;

export interface Unit {
  readonly scale: number;
  readonly step: string;
}

export function numberField(label: string, unit: Unit, changed: Changed<number>, aria = label): Field<number> {
  const input = element("input", { type: "number", step: unit.step, inputmode: "decimal", "aria-label": aria });
  let shown = 0;
  input.addEventListener("change", () => {
    const value = input.valueAsNumber / unit.scale;
    if (Number.isFinite(value)) {
      changed(value);
    } else {
      input.value = written(shown, unit);
    }
  });
  return {
    node: element("label", { class: "field" }, element("span", {}, label), input),
    show(value) {
      shown = value;
      const text = written(value, unit);
      if (document.activeElement !== input || Number(input.value) === Number(text)) {
        input.value = text;
      }
    },
  };
}

/** Two decimals of what is shown, which is a tenth of a millimetre or a hundredth of a degree. */
function written(value: number, { scale }: Unit): string {
  return String(Math.round(value * scale * 100) / 100);
}

export function textField(label: string, changed: Changed<string>): Field<string> {
  const input = element("input", { type: "text", maxlength: "48", autocomplete: "off", spellcheck: "false" });
  input.addEventListener("input", () => changed(input.value));
  return {
    node: element("label", { class: "field wide" }, element("span", {}, label), input),
    show(value) {
      if (document.activeElement !== input) {
        input.value = value;
      }
    },
  };
}

export function choiceField(label: string, options: readonly (readonly [string, string])[], changed: Changed<string>): Field<string> {
  const select = element(
    "select",
    {},
    ...options.map(([value, text]) => element("option", { value }, text)),
  );
  select.addEventListener("change", () => changed(select.value));
  return {
    node: element("label", { class: "field wide" }, element("span", {}, label), select),
    show(value) {
      select.value = value;
    },
  };
}

export function checkField(label: string, changed: Changed<boolean>): Field<boolean> {
  const input = element("input", { type: "checkbox" });
  input.addEventListener("change", () => changed(input.checked));
  return {
    node: element("label", { class: "check" }, input, element("span", {}, label)),
    show(value) {
      input.checked = value;
    },
  };
}

/** A slider with its number beside it. */
export function sliderField(label: string, unit: Unit, [from, to]: readonly [number, number], changed: Changed<number>): Field<number> {
  const number = numberField("", unit, changed, label);
  const slider = element("input", {
    type: "range",
    min: String(from),
    max: String(to),
    step: String((to - from) / 200),
    "aria-label": label,
  });
  slider.addEventListener("input", () => changed(slider.valueAsNumber));
  return {
    node: element("div", { class: "slider" }, element("span", {}, label), slider, number.node),
    show(value) {
      slider.value = String(value);
      number.show(value);
    },
  };
}
