/** Names on a map that can be read: beside their marks, off all marks and off each other. */
const LETTER_PX = 6.8;
const HIGH_PX = 13;
const MARK_PX = 9; // half of what a mark takes, with air

export interface Label {
  /** The mark's middle. */
  x: number;
  y: number;
  text: string;
}

/** Where a name begins, or ends, from its mark's middle on; on its baseline. */
export interface Placing {
  x: number;
  y: number;
  "text-anchor": "start" | "middle" | "end";
}

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

// Beside, below, above: the first that is free.
const PLACINGS: readonly Placing[] = [
  { x: 10, y: 4, "text-anchor": "start" },
  { x: -10, y: 4, "text-anchor": "end" },
  { x: 0, y: 21, "text-anchor": "middle" },
  { x: 0, y: -12, "text-anchor": "middle" },
];

/** In the labels' order; null for a name without a free place.  wide: of the map, beyond which nothing is read. */
export function arrange(labels: readonly (Label | null)[], wide: number): (Placing | null)[] {
  const marks = labels.flatMap((one) => (one ? [markOf(one)] : []));
  const shown: Box[] = [];
  return labels.map((label) => {
    if (!label) return null;
    const own = markOf(label);
    const isOwn = (box: Box) => box.left === own.left && box.top === own.top;
    const others = [...shown, ...marks.filter((box) => !isOwn(box))];
    for (const placing of PLACINGS) {
      const box = boxOf(label, placing);
      if (box.left < 0 || box.right > wide || others.some((one) => overlap(one, box))) continue;
      shown.push(box);
      return placing;
    }
    return null;
  });
}

function markOf({ x, y }: Label): Box {
  return { left: x - MARK_PX, right: x + MARK_PX, top: y - MARK_PX, bottom: y + MARK_PX };
}

function boxOf({ x, y, text }: Label, placing: Placing): Box {
  const wide = text.length * LETTER_PX;
  const before = { start: 0, middle: wide / 2, end: wide }[placing["text-anchor"]];
  const left = x + placing.x - before;
  const bottom = y + placing.y + 3;
  return { left, right: left + wide, top: bottom - HIGH_PX, bottom };
}

function overlap(one: Box, other: Box): boolean {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}

/** Whether each name to the right of its mark hides none before it. */
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
