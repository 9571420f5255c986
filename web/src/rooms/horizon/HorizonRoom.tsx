/** The local vertical in images of the horizon, and whether it agrees with a plan's attitude. */
import { useState } from "preact/hooks";

import example from "../../../../examples/horizon_estimate.json";
import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { RoomProps } from "../../room";
import { type Estimate, estimate, type HorizonRequest, readRequest } from "./estimate";
import { Frames } from "./Frames";
import { FromPlan } from "./FromPlan";
import "./horizon.css";
import { Result } from "./Result";

export default function HorizonRoom(_: RoomProps) {
  const text = words.value;
  const [request, setRequest] = useState(JSON.stringify(example, null, 2));
  const [frames, setFrames] = useState<File[]>([]);
  const [found, setFound] = useState<Estimate | null>(null);
  const [isAtWork, setAtWork] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const read = readRequest(request);
  const asked: HorizonRequest | null = typeof read === "string" ? null : read;
  const cameras = asked?.cameras ?? [];

  const measure = async () => {
    if (!asked) return;
    setAtWork(true);
    setError(null);
    setFound(null);
    try {
      setFound(await estimate(asked, frames));
    } catch (caught) {
      setError(caught);
    } finally {
      setAtWork(false);
    }
  };
  return (
    <div class="room">
      <h1>{text.shell.rooms.horizon}</h1>
      <p>{text.horizon.what}</p>
      <div class="horizon">
        <section class="panel" aria-labelledby="horizon-frames">
          <h2 id="horizon-frames">{text.horizon.frames}</h2>
          <Frames cameras={cameras.map((camera) => camera.name)} frames={frames} onFrames={setFrames} />
        </section>
        <section class="panel" aria-labelledby="horizon-request">
          <h2 id="horizon-request">{text.horizon.request}</h2>
          <FromPlan request={asked} onRequest={(filled) => setRequest(JSON.stringify(filled, null, 2))} />
          <Field label={text.horizon.json} hint={text.horizon.jsonHint} error={typeof read === "string" ? read : undefined}>
            {(control) => (
              <textarea
                {...control}
                rows={12}
                spellcheck={false}
                value={request}
                onInput={(event) => setRequest(event.currentTarget.value)}
              />
            )}
          </Field>
        </section>
      </div>
      <div class="row">
        <button
          type="button"
          class="primary"
          disabled={isAtWork || !asked || frames.length === 0 || frames.length !== cameras.length}
          onClick={() => void measure()}
        >
          {text.horizon.measure}
        </button>
        <span role="status">{isAtWork ? text.horizon.atWork : text.horizon.count(frames.length, cameras.length)}</span>
      </div>
      {error !== null && <ProblemNotice error={error} again={() => void measure()} />}
      {found && <Result found={found} />}
    </div>
  );
}
