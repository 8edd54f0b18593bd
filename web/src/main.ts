// Puts the page together.

import { socketUrl, StudioConnection } from "./connection";
import { element, required } from "./dom";
import { controls } from "./panels/controls";
import { drivePadPanel } from "./panels/drive_pad_panel";
import { eventsPanel } from "./panels/events_panel";
import { learnPanel } from "./panels/learn_panel";
import { legendPanel } from "./panels/legend_panel";
import { planPanel } from "./panels/plan_panel";
import { statusBar } from "./panels/status_bar";
import { Store } from "./store";
import { TEXT } from "./text";

async function main(): Promise<void> {
  const store = new Store();
  const connection = new StudioConnection(store, socketUrl(window.location));
  const stage = required("stage");
  statusBar(store, required("bar"));
  stage.append(controls(store, connection), drivePadPanel(store, connection));
  stage.after(legendPanel(store));
  required("panels").append(planPanel(store), learnPanel(store), eventsPanel(store));
  connection.open();

  // The panels work before the renderer has arrived, and without it.
  const { createView } = await import("./view/view");
  const view = createView(store, stage, () => undefined);
  if (view === null) {
    stage.prepend(element("p", { class: "no-webgl", role: "alert" }, TEXT.noWebGl));
  }
}

void main();
