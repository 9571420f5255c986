/** The page's address, and the way to another without loading the page anew. */
import { signal } from "@preact/signals";

// The service says by <base> where the page's root is, whatever a proxy puts before it.
const BASE = new URL(document.baseURI).pathname;

export interface Place {
  /** From the page's root on: "/plans/01J..." */
  path: string;
  query: URLSearchParams;
}

export const place = signal<Place>(here());

/** An address of the page, or of the service, from its root ("/docs"). */
export function address(path: string): string {
  return BASE + path.replace(/^\//, "");
}

export function go(path: string, { replace = false } = {}): void {
  history[replace ? "replaceState" : "pushState"](null, "", address(path));
  place.value = here();
  window.scrollTo(0, 0);
}

/** The parts of a path that a pattern names: ("/plans/:id", "/plans/7") is {id: "7"}; null where it doesn't fit. */
export function match(pattern: string, path: string): Record<string, string> | null {
  const wanted = pattern.split("/");
  const given = path.replace(/(.)\/$/, "$1").split("/");
  if (wanted.length !== given.length) return null;
  const found: Record<string, string> = {};
  for (const [index, word] of wanted.entries()) {
    const text = given[index] ?? "";
    if (word.startsWith(":")) {
      const part = decoded(text);
      if (part === null) return null;
      found[word.slice(1)] = part;
    } else if (word !== text) return null;
  }
  return found;
}

/** Null for what is no text in UTF-8, such as a lone "%". */
function decoded(text: string): string | null {
  try {
    return decodeURIComponent(text);
  } catch {
    return null;
  }
}

function here(): Place {
  const path = `/${location.pathname.slice(BASE.length)}`;
  return { path, query: new URLSearchParams(location.search) };
}

window.addEventListener("popstate", () => {
  place.value = here();
});
