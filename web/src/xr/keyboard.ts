// Letters to point at, for names: a headset has no keys.

import { plainName } from "../teach/lesson";
import { HEADSET, words } from "../text";
import { EMPTY_MENU, type Menu, type MenuButton } from "./menu";

const ROWS = ["1234567890", "qwertyuiop", "asdfghjkl", "zxcvbnm"] as const;

/** A name that is being written. */
export interface Writing {
  readonly what: string;
  readonly text: string;
  /** Takes up the name that was written. */
  readonly finish: (name: string) => void;
}

/** The keys; `write` changes what is written, or ends it with null. */
export function keyboardMenu(writing: Writing, write: (next: Writing | null) => void): Menu {
  const { text } = writing;
  const key = (label: string, to: string): MenuButton => ({ label, run: () => write({ ...writing, text: to }) });
  const name = plainName(text);
  return {
    ...EMPTY_MENU,
    title: HEADSET.naming(writing.what),
    body: `${words(text)}_`,
    rows: [
      ...ROWS.map((row) => [...row].map((letter) => key(letter, text + letter))),
      [key(HEADSET.space, text === "" ? text : `${text} `), key(HEADSET.erase, text.slice(0, -1)), key(HEADSET.clear, "")],
      [
        { label: HEADSET.cancel, run: () => write(null) },
        {
          label: HEADSET.done,
          isPrimary: true,
          isDisabled: name === "",
          run: () => {
            write(null);
            writing.finish(name);
          },
        },
      ],
    ],
  };
}
