// From a text frame to a message.

import type { ServerMessage } from "./protocol";

type MessageType = ServerMessage["type"];

// A record, so that the compiler says when the protocol has a type that is not here.
const TYPES: Record<MessageType, true> = {
  hello: true,
  scene: true,
  state: true,
  map: true,
  aosm: true,
  plan: true,
  base_path: true,
  status: true,
  control: true,
  event: true,
  done: true,
  trainings: true,
  teaching: true,
  edit_answer: true,
};

function isServerMessage(value: unknown): value is ServerMessage {
  return (
    typeof value === "object" &&
    value !== null &&
    "type" in value &&
    typeof value.type === "string" &&
    Object.hasOwn(TYPES, value.type)
  );
}

/**
 * The message, or a sentence that says what the text is instead. The fields are taken on trust:
 * they are generated from the same types at both ends, and `Hello` tells when the ends differ.
 */
export function decode(text: string): ServerMessage | string {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return `not JSON: ${text.slice(0, 40)}`;
  }
  return isServerMessage(value) ? value : `not a message: ${text.slice(0, 40)}`;
}
