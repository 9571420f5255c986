/** Names on a map that can be read: beside their marks, off all marks and off each other. */
const LETTER_PX = 6.8;
const HIGH_PX = 13;
const MARK_PX = 9; // half of what a mark takes, with air
const CELL_PX = 40; // about as wide as a short name

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

/**
 * Where each mark's name stands: in the marks' order; null for a name without a free place.
 * wide: of the map, beyond which nothing is read.
 */
export function placeNames(
  points: readonly (readonly [number, number] | null)[],
  names: readonly string[],
  wide: number,
): (Placing | null)[] {
  const boxes = new Boxes();
  const marks = points.map((point) => point && boxes.add(markOf(point)));
  return points.map((point, k) => {
    if (!point) return null;
    for (const placing of PLACINGS) {
      const box = boxOf(point, names[k] ?? "", placing);
      if (box.left < 0 || box.right > wide || boxes.meet(box, marks[k] ?? null)) continue;
      boxes.add(box);
      return placing;
    }
    return null;
  });
}

/** Boxes found by the cells of a grid that they touch: as many as lie around, not all, are compared. */
class Boxes {
  private readonly cells = new Map<string, Box[]>();

  add(box: Box): Box {
    for (const key of cellsOf(box)) {
      const held = this.cells.get(key);
      if (held) held.push(box);
      else this.cells.set(key, [box]);
    }
    return box;
  }

  /** Whether it lies on any of them; on marks in its own mark's very place it may. */
  meet(box: Box, own: Box | null): boolean {
    const isOwn = (one: Box) => own !== null && one.left === own.left && one.top === own.top;
    return cellsOf(box).some((key) => this.cells.get(key)?.some((one) => !isOwn(one) && overlap(one, box)));
  }
}

function cellsOf({ left, right, top, bottom }: Box): string[] {
  const keys: string[] = [];
  for (let x = Math.floor(left / CELL_PX); x <= Math.floor(right / CELL_PX); x++)
    for (let y = Math.floor(top / CELL_PX); y <= Math.floor(bottom / CELL_PX); y++) keys.push(`${x},${y}`);
  return keys;
}

function markOf([x, y]: readonly [number, number]): Box {
  return { left: x - MARK_PX, right: x + MARK_PX, top: y - MARK_PX, bottom: y + MARK_PX };
}

function boxOf([x, y]: readonly [number, number], text: string, placing: Placing): Box {
  const wide = text.length * LETTER_PX;
  const before = { start: 0, middle: wide / 2, end: wide }[placing["text-anchor"]];
  const left = x + placing.x - before;
  const bottom = y + placing.y + 3;
  return { left, right: left + wide, top: bottom - HIGH_PX, bottom };
}

function overlap(one: Box, other: Box): boolean {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}
