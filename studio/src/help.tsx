// The keys, in a dialog.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { opened } from "./document";
import { IconButton } from "./icons";

export const isHelping = signal(false);

const KEYS: [string, string][] = [
  ["1 – 9", "choose a light"],
  ["Arrows on a light", "move it by 2°, with Shift by ¼°"],
  ["+ −, or scroll on the dome", "intensity, with Shift finer"],
  ["Shift while dragging", "move a light finely"],
  ["L, Delete on a light", "lock, remove"],
  ["V, H, S, R", "tools: orbit, highlight, shading, rim"],
  ["Arrows on the picture", "orbit, or move the cross; Enter places the light"],
  ["+ −, Home on the picture", "zoom, first view"],
  ["Double click on the model", "turn about this point"],
  ["Space", "start or pause the search"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["Ctrl O, Ctrl S", "open, save"],
];

export function HelpDialog() {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = isHelping.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open]);
  return (
    <dialog ref={dialog} aria-labelledby="help-title" onClose={() => (isHelping.value = false)}>
      <div class="panel-head">
        <h2 id="help-title">Keys and pointer</h2>
        <IconButton icon="close" label="Close" class="quiet" onClick={() => (isHelping.value = false)} />
      </div>
      <dl class="keys">
        {KEYS.map(([keys, does]) => (
          <div key={keys}>
            <dt>{keys}</dt>
            <dd>{does}</dd>
          </div>
        ))}
      </dl>
      <p class="note">
        The dome shows all directions that light can come from: its middle is the viewer, the bold circle the side, its rim
        behind the model. Bright places of the map are where the chosen light makes F low.
        {opened.value && ` klieg ${opened.value.version}.`}
      </p>
    </dialog>
  );
}
