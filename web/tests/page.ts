/** A browser's address bar, as far as the modules under test look at it. */
import { vi } from "vitest";

export function page(path: string): void {
  const where = new URL(path, "http://service.test/planner/");
  vi.stubGlobal("document", { baseURI: "http://service.test/planner/", documentElement: {} });
  vi.stubGlobal("location", where);
  vi.stubGlobal("localStorage", { getItem: () => null, setItem: () => undefined });
  vi.stubGlobal("sessionStorage", { getItem: () => null, setItem: () => undefined });
  vi.stubGlobal("history", {
    pushState: (_: unknown, __: string, to: string) => {
      where.href = new URL(to, where).href;
    },
  });
  vi.stubGlobal("window", { addEventListener: () => undefined, scrollTo: () => undefined });
}

page("/planner/");
