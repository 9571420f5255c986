/** The stage that work is at, in the page's words. */
import { words } from "../i18n";
import type { Progress } from "./job";

/** One that isn't named is shown as the service says it. */
export function stageText({ stage, state }: Progress): string {
  const text = words.value;
  const names: Record<string, string> = text.plan.stages;
  return names[stage ?? ""] ?? stage ?? text.shell.states[state];
}
