/** Parts of the page itself that are loaded when they are needed. */
const PAUSES_MS = [1000, 2000, 4000];

/** Asked for again where they don't come at once: the service may be busy, or just starting. */
export async function part<T>(load: () => Promise<T>): Promise<T> {
  for (const pause_ms of PAUSES_MS) {
    try {
      return await load();
    } catch {
      await new Promise((resolve) => setTimeout(resolve, pause_ms));
    }
  }
  return load();
}
