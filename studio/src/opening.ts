// Files come in: chosen, or dropped anywhere on the page.
import { signal } from "@preact/signals";
import { complain } from "./notices";
import { openFile } from "./scene";

/** Files that klieg reads. */
const ENDINGS = [".glb", ".gltf", ".ply", ".stl", ".obj"];

/** Whether a file is held over the page. */
export const hovering = signal(false);

function take(files: FileList | null | undefined) {
  const [file] = files ?? [];
  if (!file) return;
  if (ENDINGS.some((ending) => file.name.toLowerCase().endsWith(ending))) void openFile(file);
  else complain(`${file.name} is no model that klieg reads: take one of ${ENDINGS.join(", ")}.`);
}

export function chooseFile() {
  const input = document.createElement("input");
  input.type = "file";
  input.accept = ENDINGS.join(",");
  input.onchange = () => take(input.files);
  input.click();
}

export function beginDropping() {
  const holdsFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
  document.addEventListener("dragover", (event) => {
    if (!holdsFiles(event)) return;
    event.preventDefault();
    hovering.value = true;
  });
  document.addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) hovering.value = false;
  });
  document.addEventListener("drop", (event) => {
    hovering.value = false;
    if (!holdsFiles(event)) return;
    event.preventDefault();
    take(event.dataTransfer?.files);
  });
}
