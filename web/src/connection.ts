// The socket to the studio, which comes back by itself.

import { decode } from "./decode";
import type { ClientMessage } from "./protocol";
import type { Store } from "./store";

const RETRY_SECS_FIRST = 0.5;
const RETRY_SECS_MAX = 5;

export class StudioConnection {
  private socket: WebSocket | null = null;
  private retrySecs = RETRY_SECS_FIRST;

  constructor(
    private readonly store: Store,
    private readonly url: string,
  ) {}

  open(): void {
    const socket = new WebSocket(this.url);
    this.socket = socket;
    let greeted = false;
    socket.addEventListener("message", (event: MessageEvent<unknown>) => {
      const message =
        typeof event.data === "string" ? decode(event.data) : "a binary frame, expected text";
      if (typeof message === "string") {
        console.warn(`studio sent something else: ${message}`);
        return;
      }
      if (message.type === "hello") {
        greeted = true;
        this.retrySecs = RETRY_SECS_FIRST;
      }
      this.store.receive(message);
    });
    socket.addEventListener("close", () => {
      this.socket = null;
      void this.comeBack(greeted);
    });
  }

  /** Sends a command; false when there is no connection to send it on. */
  send(command: ClientMessage): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) {
      return false;
    }
    this.socket.send(JSON.stringify(command));
    // A velocity shows in how the robot moves, and an edit is answered; neither shows in the status.
    if (command.type !== "drive" && command.type !== "edit") {
      this.store.sent(command.type);
    }
    return true;
  }

  private async comeBack(greeted: boolean): Promise<void> {
    const retryInSecs = this.retrySecs;
    this.retrySecs = Math.min(2 * this.retrySecs, RETRY_SECS_MAX);
    // A browser does not say why a socket was refused, but the studio's health does not ask who
    // we are: when it answers and the socket does not, it is us.
    const refused = !greeted && (await answers());
    this.store.connection(refused ? { kind: "refused" } : { kind: "lost", retryInSecs });
    setTimeout(() => this.open(), 1000 * retryInSecs);
  }
}

async function answers(): Promise<boolean> {
  try {
    const response = await fetch("/api/health", { cache: "no-store" });
    return response.ok;
  } catch {
    return false;
  }
}

/** Where the studio that served this page has its socket. */
export function socketUrl(page: Location): string {
  const scheme = page.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${page.host}/api/socket`;
}
