/** Levels of an axis, and how they are told. */
import { fixed } from "../i18n/forms";

/** Levels of an even scale, all with the decimals that tell them apart; zero has no sign. */
export function labels(splits: readonly number[]): string[] {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0));
  const decimals = Math.min(Math.max(0, -Math.floor(Math.log10(step * (1 + 1e-9)))), 12);
  const isFiner = Math.abs(step - Number(step.toFixed(decimals))) > step * 1e-6; // 0.25, 2.5e-4
  return splits.map((split) => fixed(split, isFiner ? decimals + 1 : decimals));
}

/** Round levels, about so many as there is room for, and never fewer than two: one alone is no scale. */
export function ticks([low, high]: readonly [number, number], atMost: number): number[] {
  const rough = (high - low) / Math.max(atMost, 2);
  const power = 10 ** Math.floor(Math.log10(rough));
  const rounds = [10, 5, 2, 1, 0.5].map((one) => one * power);
  const from = rounds.findLastIndex((step) => step >= rough);
  for (const step of rounds.slice(from)) {
    const found: number[] = [];
    for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(Number((k * step).toPrecision(10)) + 0);
    if (found.length > 1) return found;
  }
  return [];
}
