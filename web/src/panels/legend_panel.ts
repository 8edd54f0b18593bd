// What the numbers and colours on the floor mean.

import { element } from "../dom";
import { inkOn, regionColour } from "../palette";
import type { NavigationRegion } from "../protocol";
import type { Store } from "../store";
import { countsText, posesText, TEXT, words } from "../text";

export function legendPanel(store: Store): HTMLElement {
  const counts = element("p", { class: "aside" });
  const empty = element("p", { class: "empty" }, TEXT.legendEmpty);
  const list = element("ul", { class: "regions" });
  const panel = element(
    "section",
    { class: "panel legend", "aria-labelledby": "legend-title" },
    element("header", {}, element("h2", { id: "legend-title" }, TEXT.legend)),
    empty,
    list,
    counts,
  );
  store.watch(["aosm"], () => {
    const aosm = store.get("aosm");
    const regions = aosm?.regions ?? [];
    empty.hidden = regions.length > 0;
    list.replaceChildren(...regions.map(regionItem));
    counts.hidden = aosm === null;
    counts.textContent =
      aosm === null ? "" : countsText(aosm.classes.length, aosm.objects.length, aosm.edges.length);
  });
  store.watch(["wishes"], () => {
    list.dataset["off"] = String(!store.get("wishes").regions);
  });
  return panel;
}

function regionItem(region: NavigationRegion, index: number): HTMLElement {
  const colour = regionColour(region.colour_index);
  const chip = element("span", { class: "number" }, String(index + 1));
  chip.style.backgroundColor = colour;
  chip.style.color = inkOn(colour);
  return element(
    "li",
    {},
    chip,
    element("span", { class: "option" }, words(region.option)),
    element("span", { class: "aside" }, posesText(region.poses.length)),
  );
}
