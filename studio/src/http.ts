// The requests that go by HTTP. All of them carry the token of the page's address.
import type { Document, SceneInfo } from "./messages";

export const token = new URLSearchParams(location.search).get("token") ?? "";

const headers = { "x-klieg-token": token };

/** Whether the server answers, and takes the token. */
export async function ping(): Promise<"well" | "refused" | "away"> {
  try {
    const answer = await fetch("/ping", { headers, cache: "no-store" });
    return answer.status === 403 ? "refused" : "well";
  } catch {
    return "away";
  }
}

/** Hands a file to the server. `progress` is told the share that has gone. */
export function upload(file: File, progress: (share: number) => void): Promise<SceneInfo> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", `/scene?name=${encodeURIComponent(file.name)}`);
    request.setRequestHeader("x-klieg-token", token);
    request.upload.onprogress = ({ loaded, total }) => progress(total ? loaded / total : 0);
    request.onload = () => {
      if (request.status === 200) resolve(JSON.parse(request.responseText) as SceneInfo);
      else reject(new Error(complaint(request.status, request.responseText, file.name)));
    };
    request.onerror = () => reject(new Error(`${file.name} could not be sent: the server took no more of it.`));
    request.send(file);
  });
}

function complaint(status: number, text: string, name: string): string {
  if (status === 413) return `${name} is larger than the server takes.`;
  try {
    return (JSON.parse(text) as { error: string }).error;
  } catch {
    return `The server answered ${status}.`;
  }
}

export type Saved = "glb" | "png" | "rig" | "session";

/** Asks for a file of the document, and hands it to the browser to keep. */
export async function save(kind: Saved, document: Document, name: string, picture: object = {}): Promise<void> {
  const answer = await fetch(`/save/${kind}`, {
    method: "POST",
    headers: { ...headers, "content-type": "application/json" },
    body: JSON.stringify({ document, ...picture }),
  });
  if (!answer.ok) throw new Error(complaint(answer.status, await answer.text(), name));
  const link = window.document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
