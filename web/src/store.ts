// The page's one store. Messages and people's wishes come in, everything drawn is read from here.
//
// What is drawn is split into slices. A slice is replaced, never changed, and who asked to hear
// of it is called once for it. `live` changes up to sixty times a second: the scene reads it in
// its own time rather than being called.

import {
  type Aosm,
  type BasePath,
  type ClientMessage,
  type Done,
  type EditAnswer,
  type Event as JobEvent,
  type OccupancyMap,
  type Plan,
  type Role,
  type Scene,
  type SceneSource,
  type ServerMessage,
  type State,
  type Status,
  type Teaching,
  type Training,
  VERSION,
} from "./protocol";
import { type Draft, type Lesson, NO_DRAFT, OVERVIEW, stillStands } from "./teach/lesson";
import type { Alignment, AlignedBy, MapFromXr } from "./xr/map_from_xr";
import type { Mode, Offer } from "./xr/offer";

export type Connection =
  | { kind: "connecting" }
  | { kind: "open" }
  | { kind: "lost"; retryInSecs: number }
  /** The studio answers, but not to us: its cookie is of another run. */
  | { kind: "refused" }
  /** Page and studio are of different versions. */
  | { kind: "mismatch"; theirs: number };

/** What a person has chosen to see. */
export interface Wishes {
  readonly follow: boolean;
  readonly map: boolean;
  readonly regions: boolean;
  readonly labels: boolean;
}

/** How a person likes to drag: kept by the browser from one day to the next. */
export interface Hand {
  readonly mode: "move" | "turn";
  readonly snap: boolean;
  /** Share of the hand's way that things go, 0 to 1: small for fine work. */
  readonly speed: number;
}

/** The headset, as far as the page knows of one. */
export interface Headset {
  readonly offer: Offer;
  /** How it is worn now; null when it is not. */
  readonly worn: Mode | null;
  /** It has lost where it is: what is seen lies nowhere for certain. */
  readonly lost: boolean;
  /** Why it could not be entered; empty when it could. */
  readonly problem: string;
}

export interface Slices {
  connection: Connection;
  session: string | null;
  /** This page's own name and what it may do; the studio says so in its greeting. */
  client: string;
  role: Role;
  /** The page that has the robot; none when it is free. */
  owner: string | null;
  scenes: ReadonlyMap<SceneSource, Scene>;
  live: State | null;
  map: OccupancyMap | null;
  aosm: Aosm | null;
  plan: Plan | null;
  path: BasePath | null;
  status: Status | null;
  events: readonly JobEvent[];
  done: Done | null;
  trainings: readonly Training[];
  wishes: Wishes;
  /** The home as it can be taught; none where a robot is at work. */
  teaching: Teaching | null;
  /** The latest answer to an edit of this page. */
  answer: EditAnswer | null;
  /** What is being taught. */
  lesson: Lesson;
  /** What of it is not saved yet. */
  draft: Draft;
  hand: Hand;
  headset: Headset;
  /** Where the headset's space lies in the map. */
  alignment: Alignment;
  /** Edits that wait for their answer. */
  unanswered: number;
  /** Why the last edit was refused; empty when it was not. */
  refusal: string;
  /** A command that was sent and has not yet shown in `status`. */
  waiting: ClientMessage["type"] | null;
}

/** More events than anybody reads on a page; the run folder keeps them all. */
export const EVENTS_MAX = 500;

/** What a person is at, which a new connection does not change. */
type Own = "wishes" | "lesson" | "draft" | "hand" | "headset" | "alignment" | "unanswered" | "refusal";
type Picture = Omit<Slices, "connection" | Own>;

function emptyPicture(): Picture {
  return {
    session: null,
    client: "",
    role: "view",
    owner: null,
    scenes: new Map(),
    live: null,
    map: null,
    aosm: null,
    plan: null,
    path: null,
    status: null,
    events: [],
    done: null,
    trainings: [],
    teaching: null,
    answer: null,
    waiting: null,
  };
}

const ROLES: readonly Role[] = ["view", "teach", "execute"];

type Listener = () => void;

export class Store {
  private readonly slices: Slices = {
    ...emptyPicture(),
    connection: { kind: "connecting" },
    wishes: { follow: false, map: true, regions: true, labels: true },
    lesson: OVERVIEW,
    draft: NO_DRAFT,
    hand: { mode: "move", snap: true, speed: 1 },
    headset: { offer: { kind: "asking" }, worn: null, lost: false, problem: "" },
    alignment: { mapFromXr: { position: [0, 0, 0], yaw: 0 }, epoch: 0, by: "placed" },
    unanswered: 0,
    refusal: "",
  };
  private readonly listeners = new Map<keyof Slices, Set<Listener>>();

  get<K extends keyof Slices>(slice: K): Readonly<Slices[K]> {
    return this.slices[slice];
  }

  /** Calls back whenever one of the slices is replaced, and once now; until what it gives back is called. */
  watch(slices: readonly (keyof Slices)[], listener: Listener): () => void {
    for (const slice of slices) {
      const set = this.listeners.get(slice) ?? new Set();
      set.add(listener);
      this.listeners.set(slice, set);
    }
    listener();
    return () => slices.forEach((slice) => this.listeners.get(slice)?.delete(listener));
  }

  /** Takes in a message of the studio. */
  receive(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        this.forget();
        this.set("session", message.session);
        this.set("client", message.client);
        this.set("role", message.role);
        if (message.version === VERSION) {
          this.set("connection", { kind: "open" });
        } else {
          this.set("connection", { kind: "mismatch", theirs: message.version });
        }
        return;
      case "scene":
        this.set("scenes", new Map(this.slices.scenes).set(message.source, message));
        return;
      case "state":
        this.set("live", message);
        return;
      case "map":
        this.set("map", message);
        return;
      case "aosm":
        this.set("aosm", message);
        return;
      case "plan":
        this.set("plan", message);
        return;
      case "base_path":
        this.set("path", message);
        return;
      case "status":
        this.set("status", message);
        this.set("waiting", null);
        return;
      case "control":
        this.set("owner", message.owner);
        return;
      case "event":
        this.set("events", [...this.slices.events, message].slice(-EVENTS_MAX));
        return;
      case "done":
        this.set("done", message);
        this.set("waiting", null);
        return;
      case "trainings":
        this.set("trainings", message.trainings);
        return;
      case "teaching":
        this.set("teaching", message);
        if (!stillStands(this.slices.lesson, message)) {
          this.learn(OVERVIEW);
        }
        return;
      case "edit_answer":
        this.set("answer", message);
        return;
    }
  }

  /** Notes how the connection stands. A lost one keeps the last picture. */
  connection(connection: Connection): void {
    this.set("connection", connection);
    if (connection.kind !== "open") {
      this.set("waiting", null);
    }
  }

  /** Notes that a command was sent. */
  sent(command: ClientMessage["type"]): void {
    this.set("waiting", command);
  }

  /** Goes to another step of teaching, with what is not saved of it. */
  learn(lesson: Lesson, draft: Draft = NO_DRAFT): void {
    this.set("draft", draft);
    this.set("lesson", lesson);
  }

  /** Changes what is not saved. */
  drafted(draft: Partial<Draft>): void {
    this.set("draft", { ...this.slices.draft, ...draft });
  }

  /** Notes how edits stand. */
  edits(unanswered: number, refusal: string): void {
    this.set("unanswered", unanswered);
    this.set("refusal", refusal);
  }

  handed(hand: Partial<Hand>): void {
    this.set("hand", { ...this.slices.hand, ...hand });
  }

  worn(headset: Partial<Headset>): void {
    this.set("headset", { ...this.slices.headset, ...headset });
  }

  /** Notes that the headset's space lies elsewhere now. */
  aligned(mapFromXr: MapFromXr, by: AlignedBy): void {
    this.set("alignment", { mapFromXr, by, epoch: this.slices.alignment.epoch + 1 });
  }

  toggle(wish: keyof Wishes): void {
    this.set("wishes", { ...this.slices.wishes, [wish]: !this.slices.wishes[wish] });
  }

  /** Whether this page may do what takes a role. Each may do what those before it may. */
  may(role: Role): boolean {
    return ROLES.indexOf(this.slices.role) >= ROLES.indexOf(role);
  }

  /** The job takes commands: it runs, and this page is connected to it. */
  takesCommands(): boolean {
    const { connection, status, done } = this.slices;
    const over = status?.activity === "finished" || status?.activity === "stopped";
    return connection.kind === "open" && status !== null && !over && done === null;
  }

  /** The job takes velocities from a hand. */
  takesDriving(): boolean {
    const { status } = this.slices;
    return this.takesCommands() && this.may("execute") && status?.takes_driving === true && !status.paused;
  }

  private forget(): void {
    const empty = emptyPicture();
    Object.assign(this.slices, empty);
    for (const slice of Object.keys(empty)) {
      this.tell(slice as keyof Picture);
    }
  }

  private set<K extends keyof Slices>(slice: K, value: Slices[K]): void {
    if (this.slices[slice] !== value) {
      this.slices[slice] = value;
      this.tell(slice);
    }
  }

  private tell(slice: keyof Slices): void {
    for (const listener of this.listeners.get(slice) ?? []) {
      listener();
    }
  }
}
