/** What is asked of a plan. */
import { useState } from "preact/hooks";

import example from "../../../../examples/las_vegas_2015.json";
import { type Progress, sendOff, untilDone } from "../../api/job";
import { words } from "../../i18n";
import { Bar } from "../../parts/Bar";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { go } from "../../router";
import type { RoomProps } from "../../rooms";

export default function AskRoom(_: RoomProps) {
  const text = words.value;
  const [progress, setProgress] = useState<Progress | null>(null);
  const [error, setError] = useState<unknown>(null);
  const plan = async () => {
    setError(null);
    try {
      const sent = await sendOff("/v1/plans", example);
      await untilDone(sent, setProgress);
      go(`/plans/${sent.id}`);
    } catch (caught) {
      setError(caught);
    } finally {
      setProgress(null);
    }
  };
  return (
    <div class="room">
      <h1>{text.shell.rooms.plan}</h1>
      <button type="button" class="primary" disabled={progress !== null} onClick={() => void plan()}>
        {text.plan.plan}
      </button>
      {progress && <Bar label={text.shell.states[progress.state]} percent={progress.percent} />}
      {error !== null && <ProblemNotice error={error} again={() => void plan()} />}
    </div>
  );
}
