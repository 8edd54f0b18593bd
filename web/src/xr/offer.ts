// Whether this browser lets a person teach in a headset, and if not, why.

export type Mode = "immersive-ar" | "immersive-vr";

export type Offer =
  | { readonly kind: "asking" }
  | { readonly kind: "offered"; readonly mode: Mode }
  /** `insecure`: browsers open headsets only to pages over https, or of this computer. */
  | { readonly kind: "none"; readonly why: "insecure" | "no_webxr" | "no_headset" };

/** Through which one sees the room, before which one does not. */
const MODES: readonly Mode[] = ["immersive-ar", "immersive-vr"];

/** What a browser says of itself. */
export interface Surrounds {
  readonly isSecureContext: boolean;
  readonly xr: Pick<XRSystem, "isSessionSupported"> | undefined;
}

export async function offerOf({ isSecureContext, xr }: Surrounds): Promise<Offer> {
  // An emulator, or an extension, may bring WebXR where the browser itself would refuse it: so this is asked first.
  if (!isSecureContext) {
    return { kind: "none", why: "insecure" };
  }
  if (xr === undefined) {
    return { kind: "none", why: "no_webxr" };
  }
  for (const mode of MODES) {
    if (await isSupported(xr, mode)) {
      return { kind: "offered", mode };
    }
  }
  return { kind: "none", why: "no_headset" };
}

async function isSupported(xr: Pick<XRSystem, "isSessionSupported">, mode: Mode): Promise<boolean> {
  try {
    return await xr.isSessionSupported(mode);
  } catch {
    // Forbidden by a policy of the page, or of the person.
    return false;
  }
}
