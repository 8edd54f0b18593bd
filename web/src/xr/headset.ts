// Putting a headset on and taking it off.

import type { Desk } from "../teach/desk";
import type { View } from "../view/view";
import { showToPrograms } from "./probe";
import { HeadsetSession } from "./session";

/** What is worn now; one at most. */
export class Headset {
  private worn: HeadsetSession | null = null;

  constructor(
    private readonly desk: Desk,
    private readonly view: View,
  ) {
    showToPrograms(() => this.worn?.seen() ?? null);
  }

  /** Enters the headset that is offered. Browsers take this only from a person's own click. */
  async enter(): Promise<void> {
    const { store } = this.desk;
    const { offer, worn } = store.get("headset");
    if (offer.kind !== "offered" || worn !== null || navigator.xr === undefined) {
      return;
    }
    store.worn({ problem: "" });
    let session: XRSession | null = null;
    try {
      session = await navigator.xr.requestSession(offer.mode, {
        requiredFeatures: ["local-floor"],
        optionalFeatures: ["hand-tracking"],
      });
      await this.wear(session, offer.mode);
    } catch (error) {
      this.takeOff();
      store.worn({ worn: null, problem: error instanceof Error ? error.message : String(error) });
      await session?.end().catch(() => undefined);
    }
  }

  private async wear(session: XRSession, mode: "immersive-ar" | "immersive-vr"): Promise<void> {
    const { xr } = this.view.renderer;
    const worn = new HeadsetSession(this.desk, this.view, session, mode);
    this.worn = worn;
    xr.enabled = true;
    xr.setReferenceSpaceType("local-floor");
    await xr.setSession(session);
    const space = xr.getReferenceSpace();
    if (space !== null) {
      worn.follow(space);
    }
    // After the renderer's own, which puts the canvas back to what it was.
    session.addEventListener("end", () => this.takeOff());
    this.view.wear(worn);
    this.desk.store.worn({ worn: mode, lost: false });
  }

  private takeOff(): void {
    if (this.worn !== null) {
      this.worn.dispose();
      this.worn = null;
      this.view.wear(null);
      this.desk.store.worn({ worn: null, lost: false });
    }
  }
}
