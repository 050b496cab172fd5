// Saving: the lit model, a picture of any size, the rig, the session.
import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { doc, scene } from "./document";
import { save, type Saved } from "./http";
import { Icon, IconButton } from "./icons";
import { complain, say } from "./notices";

/** Most pixels along a side of a saved picture. */
const MOST_SIDE = 8192;

const saving = signal<Saved | null>(null);
export const isSaving = signal(false);

const FILES: { kind: Saved; title: string; text: string; suffix: string }[] = [
  { kind: "glb", title: "Lit model", text: "The model with its lights and camera, for Blender, three.js and engines.", suffix: ".lit.glb" },
  { kind: "rig", title: "Rig", text: "The lights alone as JSON, for klieg render, score and design.", suffix: ".rig.json" },
  { kind: "session", title: "Session", text: "Model, lights and all that is wanted of them in one file, to go on later.", suffix: ".session.glb" },
];

/** The scene's name without its ending. */
function stem(): string {
  const name = scene.value?.name.replace(/^.*[/\\]/, "") ?? "scene";
  return name.replace(/(\.(lit|session))?\.(glb|gltf|ply|stl|obj)$/i, "") || "scene";
}

async function write(kind: Saved, suffix: string, picture: object = {}) {
  if (!doc.value || saving.value) return;
  saving.value = kind;
  try {
    const name = `${stem()}${suffix}`;
    await save(kind, doc.value, name, picture);
    say(`${name} is saved.`);
    isSaving.value = false;
  } catch (error) {
    isSaving.value = false;
    complain(error);
  } finally {
    saving.value = null;
  }
}

const width = signal(2048);
const samples = signal(16);

function PictureFile() {
  const size = doc.value?.size ?? [1, 1];
  const height = Math.max(1, Math.round((width.value * size[1]) / size[0]));
  const sane = width.value >= 16 && Math.max(width.value, height) <= MOST_SIDE;
  return (
    <li>
      <h3>Picture</h3>
      <p class="note">Anti-aliased, with exact shadows, as PNG.</p>
      <div class="row">
        <label class="choice">
          <span>Width</span>
          <input type="number" min={16} max={MOST_SIDE} value={width.value} onInput={(event) => (width.value = Math.round(event.currentTarget.valueAsNumber) || 0)} />
        </label>
        <span class="soft">× {height}</span>
        <label class="choice">
          <span>Samples a pixel</span>
          <select value={samples.value} onChange={(event) => (samples.value = Number(event.currentTarget.value))}>
            {[1, 4, 9, 16, 25, 36, 64].map((count) => <option key={count} value={count}>{count}</option>)}
          </select>
        </label>
        <SaveButton kind="png" title="Picture" disabled={!sane} onClick={() => write("png", ".png", { width: width.value, height, samples: samples.value })} />
      </div>
    </li>
  );
}

const SaveButton = ({ kind, title, disabled, onClick }: { kind: Saved; title: string; disabled?: boolean; onClick: () => void }) => (
  <button type="button" class="button right" data-save={kind} aria-label={`Save ${title.toLowerCase()}`} disabled={disabled || saving.value !== null} onClick={onClick}>
    <Icon name="save" />
    <span>{saving.value === kind ? "Saving…" : "Save"}</span>
  </button>
);

export function SaveDialog() {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = isSaving.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.showModal();
    else if (!open) dialog.current?.close();
  }, [open]);
  return (
    <dialog ref={dialog} aria-labelledby="save-title" onClose={() => (isSaving.value = false)}>
      <div class="panel-head">
        <h2 id="save-title">Save</h2>
        <IconButton icon="close" label="Close" class="quiet" onClick={() => (isSaving.value = false)} />
      </div>
      <ul class="files">
        {FILES.slice(0, 1).map((file) => <PlainFile key={file.kind} {...file} />)}
        <PictureFile />
        {FILES.slice(1).map((file) => <PlainFile key={file.kind} {...file} />)}
      </ul>
    </dialog>
  );
}

const PlainFile = ({ kind, title, text, suffix }: (typeof FILES)[number]) => (
  <li>
    <h3>{title}</h3>
    <div class="row">
      <p class="note">{text}</p>
      <SaveButton kind={kind} title={title} onClick={() => write(kind, suffix)} />
    </div>
  </li>
);
