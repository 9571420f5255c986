/** Names on a map that can be read: those that hide none before them. */
const LETTER_PX = 6.8;
const HIGH_PX = 13;

export interface Label {
  /** Where it begins, on its middle line. */
  x: number;
  y: number;
  text: string;
}

/** In the labels' order; null where there is none. */
export function readable(labels: readonly (Label | null)[]): boolean[] {
  const shown: Label[] = [];
  return labels.map((label) => {
    if (!label) return false;
    const wide = label.text.length * LETTER_PX;
    const isFree = shown.every(
      ({ x, y, text }) => Math.abs(y - label.y) > HIGH_PX || label.x > x + text.length * LETTER_PX || label.x + wide < x,
    );
    if (isFree) shown.push(label);
    return isFree;
  });
}
