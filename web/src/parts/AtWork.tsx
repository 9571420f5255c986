import type { ComponentChildren } from "preact";

import type { Progress } from "../api/job";
import { words } from "../i18n";
import { Bar } from "./Bar";

interface Props {
  progress: Progress;
  /** The stages in the page's words; one that isn't named is shown as the service says it. */
  stages: Record<string, string>;
  onCancel: () => void;
  /** Of what is found so far. */
  children?: ComponentChildren;
}

/** Work that goes on: its stages, the one it is at, and the way to stop it. */
export function AtWork({ progress, stages, onCancel, children }: Props) {
  const text = words.value.shell;
  const names = Object.keys(stages);
  const at = progress.stage === null ? -1 : names.indexOf(progress.stage);
  const label = stages[progress.stage ?? ""] ?? progress.stage ?? text.states[progress.state];
  return (
    <section class="panel at-work" aria-label={text.states[progress.state]}>
      <ol class="stages">
        {names.map((name, index) => (
          <li key={name} class={index < at ? "stage-done" : ""} aria-current={index === at ? "step" : undefined}>
            {stages[name]}
          </li>
        ))}
      </ol>
      <div class="row" role="status">
        <Bar label={label} percent={progress.percent} />
        <button type="button" onClick={onCancel}>
          {text.cancel}
        </button>
      </div>
      {children}
    </section>
  );
}
