/** Saves what the service answers as a file; by fetch, because a link can't send an API key. */
import { type Given, send } from "./client";

export async function download(path: string, given: Given, name: string): Promise<void> {
  const answer = await send("GET", path, { ...given, headers: { Accept: "*/*", ...given.headers } });
  const told = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1];
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = told ?? name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
