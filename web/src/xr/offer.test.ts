import { describe, expect, it } from "vitest";

import { offerOf } from "./offer";

const headset = (...modes: readonly string[]): { isSessionSupported(mode: string): Promise<boolean> } => ({
  isSessionSupported: (mode) => Promise.resolve(modes.includes(mode)),
});

describe("a headset is offered", () => {
  it("with the room behind the picture where that can be, without it where it cannot", async () => {
    const both = await offerOf({ isSecureContext: true, xr: headset("immersive-vr", "immersive-ar") });
    expect(both).toEqual({ kind: "offered", mode: "immersive-ar" });
    const one = await offerOf({ isSecureContext: true, xr: headset("inline", "immersive-vr") });
    expect(one).toEqual({ kind: "offered", mode: "immersive-vr" });
  });

  it("never on a page that is not secure, whatever the browser says", async () => {
    const offer = await offerOf({ isSecureContext: false, xr: headset("immersive-ar") });
    expect(offer).toEqual({ kind: "none", why: "insecure" });
  });

  it("not without WebXR, without a headset, or where it is forbidden", async () => {
    expect(await offerOf({ isSecureContext: true, xr: undefined })).toEqual({ kind: "none", why: "no_webxr" });
    expect(await offerOf({ isSecureContext: true, xr: headset() })).toEqual({ kind: "none", why: "no_headset" });
    const forbidden = { isSessionSupported: () => Promise.reject(new DOMException("no", "SecurityError")) };
    expect(await offerOf({ isSecureContext: true, xr: forbidden })).toEqual({ kind: "none", why: "no_headset" });
  });
});
