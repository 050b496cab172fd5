// The connection: requests out, answers and pictures in, and back again after a loss.
import { signal } from "@preact/signals";
import { ping, token } from "./http";
import type { Answer, Fineness, Request } from "./messages";

export type State = "connecting" | "open" | "lost" | "refused";

/** A picture, or the thumbnail of an alternative. */
export type Picture = {
  id: number;
  thumbnail: boolean;
  index: number;
  quality: Fineness;
  milliseconds: number;
  image: ImageData;
};

export type Of<T extends Answer["type"]> = Extract<Answer, { type: T }>;
/** A request without the number that the connection gives it. */
export type Asked = Request extends infer R ? (R extends Request ? Omit<R, "id"> : never) : never;
type Fault = (id: number | null, message: string) => void;

/** Why an answer will not come: something newer has taken its place, or the connection is lost. */
export class Gone extends Error {}

type Pending = { type: string; resolve: (answer: Answer) => void; reject: (error: Error) => void };

const MAGIC = 0x4b4c4753;
const HEADER = 32;
const RETRY = 1000;

/** Open once the server knows what it is about; whoever is called by `connect` says so. */
export const connection = signal<State>("connecting");

let socket: WebSocket | null = null;
let last = 0;
const pending = new Map<number, Pending>();
const listeners = new Map<string, (answer: Answer) => void>();
let onPicture: (picture: Picture) => void = () => {};
let onOpen: () => void = () => {};
let onFault: Fault = () => {};

/** Connects, and again each time that the connection is lost. `opened` begins anew. */
export function connect(opened: () => void, pictures: (picture: Picture) => void, faults: Fault) {
  [onOpen, onPicture, onFault] = [opened, pictures, faults];
  attempt();
}

/** Calls `listener` with every answer of a type that nobody waits for. */
export function listen<T extends Answer["type"]>(type: T, listener: (answer: Of<T>) => void) {
  listeners.set(type, listener as (answer: Answer) => void);
}

/** Sends a request and gives its number; 0 where there is no connection. */
export function send(request: Asked): number {
  if (socket?.readyState !== WebSocket.OPEN) return 0;
  last += 1;
  socket.send(JSON.stringify({ ...request, id: last }));
  return last;
}

/** Sends a request and waits for its answer. An older one of its type is given up. */
export function ask(request: Asked): Promise<Answer> {
  for (const [id, { type, reject }] of pending) {
    if (type !== request.type) continue;
    pending.delete(id);
    reject(new Gone("something newer was asked"));
  }
  return new Promise((resolve, reject) => {
    const id = send(request);
    if (id) pending.set(id, { type: request.type, resolve, reject });
    else reject(new Gone("there is no connection"));
  });
}

function attempt() {
  const link = new WebSocket(`ws://${location.host}/socket?token=${encodeURIComponent(token)}`);
  link.binaryType = "arraybuffer";
  link.onopen = () => onOpen();
  link.onmessage = ({ data }) => (typeof data === "string" ? answered(JSON.parse(data)) : pictured(data));
  link.onclose = () => void lost();
  socket = link;
}

async function lost() {
  socket = null;
  for (const { reject } of pending.values()) reject(new Gone("the connection is lost"));
  pending.clear();
  if ((await ping()) === "refused") {
    connection.value = "refused";
    return;
  }
  connection.value = "lost";
  setTimeout(attempt, RETRY);
}

function answered(answer: Answer) {
  const id = answer.id ?? 0;
  const waiting = pending.get(id);
  pending.delete(id);
  if (answer.type === "fault") {
    if (waiting) waiting.reject(new Error(answer.message));
    else onFault(answer.id, answer.message);
  } else if (waiting) waiting.resolve(answer);
  else listeners.get(answer.type)?.(answer);
}

function pictured(data: ArrayBuffer) {
  const head = new DataView(data);
  const word = (index: number) => head.getUint32(4 * index, true);
  const [width, height] = [word(2), word(3)];
  if (data.byteLength < HEADER || word(0) !== MAGIC || data.byteLength !== HEADER + 4 * width * height) return;
  onPicture({
    id: word(1),
    thumbnail: word(4) === 1,
    index: word(5),
    quality: Math.min(2, word(6)) as Fineness,
    milliseconds: word(7) / 1000,
    image: new ImageData(new Uint8ClampedArray(data, HEADER), width, height),
  });
}
