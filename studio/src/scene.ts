// Scenes: the one to begin with, those that are dropped, and the way back after a lost connection.
import { effect } from "@preact/signals";
import { beginning, choose, doc, file, opened, scene } from "./document";
import * as gallery from "./gallery";
import { begin, cursor, entries } from "./history";
import { upload } from "./http";
import type { Document, Opened } from "./messages";
import { busy, complain, say } from "./notices";
import * as searching from "./searching";
import { ask, connection, Gone } from "./socket";

/** Name of this tab's document, which is kept for when the page is loaded anew. */
const KEY = "klieg-studio";

/** A document, and the name of the scene that it is of. */
type Kept = { name: string; document: Document };

/** Begins, or goes on with the page's document after the connection was lost. */
export async function connected() {
  searching.forget();
  gallery.forget();
  try {
    if (doc.value) await goOn(doc.value);
    else await open(remembered());
  } catch (error) {
    if (error instanceof Gone) return;
    complain(error);
  }
  connection.value = "open";
}

async function ofServer(id: string | null): Promise<Opened> {
  const answer = await ask({ type: "open", scene: id });
  if (answer.type !== "opened") throw new Error("The server answered something else.");
  opened.value = answer;
  return answer;
}

/** Opens a scene of the server's, with a document that was kept where it is of that scene. */
async function open(kept: Kept | null, id: string | null = kept?.document.scene ?? null): Promise<void> {
  const answer = await ofServer(id).catch((error: unknown) => {
    // What was kept may be of a scene that the server no longer has.
    if (kept && !(error instanceof Gone)) return null;
    throw error;
  });
  if (!answer) return open(null, null);
  const info = answer.scene;
  scene.value = info;
  if (!info) return;
  const document = kept?.name === info.name ? kept.document : null;
  begin(document ?? beginning(info, answer), document ? "Reloaded" : "Opened");
  choose(0);
  say(`${info.name} is open.`);
  connection.value = "open";
  if (!document && !info.document && info.lights.length === 0) searching.start();
}

/** The server has been started again: it gets the scene and the document anew. */
async function goOn(document: Document) {
  let answer: Opened;
  try {
    answer = await ofServer(document.scene);
  } catch (error) {
    if (error instanceof Gone) throw error;
    answer = await handOver();
  }
  const before = scene.value;
  scene.value = answer.scene;
  if (!answer.scene) return;
  if (answer.scene.name === before?.name) renamed(answer.scene.id);
  else begin(beginning(answer.scene, answer), "Opened");
}

/** Gives the server the file again, or takes the model of its command line. */
async function handOver(): Promise<Opened> {
  if (!file.value) return ofServer(null);
  const info = await sent(file.value);
  return ofServer(info.id);
}

/** A scene that was handed over again has another id, in all steps of the history. */
function renamed(id: string) {
  if (doc.value?.scene === id) return;
  const rename = (document: Document): Document => ({ ...document, scene: id });
  const current = entries.value[cursor.value];
  const standing = doc.value;
  entries.value = entries.value.map((entry) => ({ ...entry, document: rename(entry.document) }));
  const same = standing === current?.document;
  doc.value = same ? entries.value[cursor.value]!.document : standing && rename(standing);
}

async function sent(model: File) {
  busy.value = `Sending ${model.name}`;
  try {
    return await upload(model, (share) => {
      busy.value = share < 1 ? `Sending ${model.name}, ${Math.round(100 * share)} %` : `Reading ${model.name}`;
    });
  } finally {
    busy.value = null;
  }
}

/** Opens a file of the user's. */
export async function openFile(model: File) {
  try {
    const info = await sent(model);
    searching.forget();
    gallery.forget();
    await open(null, info.id);
    file.value = model;
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
  }
}

/** Keeps the document of this tab. */
export function beginRemembering() {
  effect(() => {
    const entry = entries.value[cursor.value];
    const kept: Kept | null = entry && scene.value ? { name: scene.value.name, document: entry.document } : null;
    try {
      if (kept) sessionStorage.setItem(KEY, JSON.stringify(kept));
    } catch {
      // A browser that keeps nothing begins anew.
    }
  });
}

function remembered(): Kept | null {
  try {
    return JSON.parse(sessionStorage.getItem(KEY) ?? "null") as Kept | null;
  } catch {
    return null;
  }
}
