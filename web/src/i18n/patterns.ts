/** Sentences of the service in the page's language, by patterns with holes. */

/** What stands in {a} is taken over as it is; in <a> it is a text of the service itself. */
const HOLE = /\{(\w+)\}|<(\w+)>/g;
const BETWEEN_SENTENCES = "; ";

interface Pattern {
  fits: RegExp;
  /** Names of the holes in their order; those in <> are told themselves. */
  holes: readonly { name: string; isTold: boolean }[];
  told: string;
}

/** table: English patterns, each with its translation; of several that fit the first is taken. */
export function tellerBy(table: Readonly<Record<string, string>>): (text: string) => string {
  const patterns = Object.entries(table).map(([english, told]): Pattern => {
    const parts = english.replace(HOLE, "\0").split("\0");
    return {
      fits: new RegExp(`^${parts.map(escaped).join("(.+?)")}$`, "s"),
      holes: [...english.matchAll(HOLE)].map(([, name, toTell]) => ({
        name: name ?? toTell ?? "",
        isTold: toTell !== undefined,
      })),
      told,
    };
  });

  function whole(text: string): string | null {
    for (const { fits, holes, told } of patterns) {
      const found = fits.exec(text);
      if (!found) continue;
      const values = holes.map(({ isTold }, k) => (isTold ? tell(found[k + 1] ?? "") : (found[k + 1] ?? "")));
      if (values.includes(null)) continue;
      const of = new Map(holes.map(({ name }, k) => [name, values[k] ?? ""]));
      return told.replace(HOLE, (_, name: string | undefined, toTell: string | undefined) => of.get(name ?? toTell ?? "") ?? "");
    }
    return null;
  }

  /** Whole, or else sentence by sentence where each has its translation. */
  function tell(text: string): string | null {
    const found = whole(text);
    if (found !== null) return found;
    const sentences = text.split(BETWEEN_SENTENCES);
    if (sentences.length === 1) return null;
    const each = sentences.map(whole);
    return each.includes(null) ? null : each.join(BETWEEN_SENTENCES);
  }

  return (text) => tell(text) ?? text;
}

function escaped(text: string): string {
  return text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
}
