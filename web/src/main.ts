// Puts the page together.

import { socketUrl, StudioConnection } from "./connection";
import { element, required } from "./dom";
import { controls } from "./panels/controls";
import { drivePadPanel } from "./panels/drive_pad_panel";
import { eventsPanel } from "./panels/events_panel";
import { headsetPanel } from "./panels/headset_panel";
import { learnPanel } from "./panels/learn_panel";
import { legendPanel } from "./panels/legend_panel";
import { planPanel } from "./panels/plan_panel";
import { statusBar } from "./panels/status_bar";
import { Store } from "./store";
import type { Desk } from "./teach/desk";
import { Edits } from "./teach/edits";
import { browserStorage, keepHand } from "./teach/hand";
import { savePlace } from "./teach/things";
import { TEXT } from "./text";
import type { View } from "./view/view";
import { offerOf } from "./xr/offer";

async function main(): Promise<void> {
  const store = new Store();
  const connection = new StudioConnection(store, socketUrl(window.location));
  let view: View | null = null;
  const desk: Desk = {
    store,
    edits: new Edits(store, (message) => connection.send(message)),
    lookedAt: () => view?.lookedAt() ?? [0, 0],
  };
  const storage = browserStorage();
  if (storage !== null) {
    keepHand(store, storage);
  }
  const stage = required("stage");
  statusBar(store, required("bar"));
  stage.append(controls(store, connection), drivePadPanel(store, connection));
  stage.after(legendPanel(store));
  const panels = required("panels");
  const door = headsetPanel(store);
  panels.append(planPanel(store), learnPanel(store), eventsPanel(store), door.node);
  // Asked for with the page itself, so that a studio that goes away later takes nothing along.
  const xr = import("./xr/headset");
  connection.open();
  void watchOffer(store);

  // The panels work before the renderer has arrived, and without it. Who teaches needs its arithmetic of poses.
  const { teachPanel } = await import("./panels/teach_panel");
  panels.prepend(teachPanel(desk));
  const { createView } = await import("./view/view");
  view = createView(store, stage, () => void savePlace(desk));
  if (view === null) {
    stage.prepend(element("p", { class: "no-webgl", role: "alert" }, TEXT.noWebGl));
    return;
  }
  const { Headset } = await xr;
  const headset = new Headset(desk, view);
  door.open(() => void headset.enter());
}

/** Notes whether a headset is offered, now and whenever one comes or goes. */
async function watchOffer(store: Store): Promise<void> {
  const { isSecureContext, navigator } = window;
  const look = async (): Promise<void> => store.worn({ offer: await offerOf({ isSecureContext, xr: navigator.xr }) });
  navigator.xr?.addEventListener("devicechange", () => void look());
  await look();
}

void main();
