/** Saves what the service answers as a file; by fetch, because a link can't send an API key. */
import { type Given, send } from "./client";

/** name: by what the service calls the file, if it says so. */
export async function download(path: string, given: Given, name: (told: string | undefined) => string): Promise<void> {
  const answer = await send("GET", path, { ...given, headers: { Accept: "*/*", ...given.headers } });
  const told = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1];
  saveBlob(await answer.blob(), name(told));
}

/** Saves a text that the page has made. */
export function saveText(text: string, name: string, type: string): void {
  saveBlob(new Blob([text], { type }), name);
}

export function saveBlob(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
