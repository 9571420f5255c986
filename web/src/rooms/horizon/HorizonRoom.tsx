/** The local vertical in images of the horizon, and whether it agrees with a plan's attitude. */
import { useState } from "preact/hooks";

import example from "../../../../examples/horizon_estimate.json";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { useKept } from "../../parts/kept";
import { useKeptPlan } from "../../parts/PlanField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { RoomProps } from "../../room";
import { place } from "../../router";
import { type Estimate, estimate, type HorizonRequest, readRequest } from "./estimate";
import { Frames } from "./Frames";
import { FromPlan } from "./FromPlan";
import "./horizon.css";
import { Result } from "./Result";

/** What was measured, and what for. */
interface Found {
  asked: HorizonRequest;
  estimate: Estimate;
}

export default function HorizonRoom(_: RoomProps) {
  const text = words.value;
  const wanted = place.value.query.get("plan");
  const [request, setRequest] = useKept("/horizon request", JSON.stringify(example, null, 2));
  const [frames, setFrames] = useState<File[]>([]);
  const [frameNames, setFrameNames] = useKept("/horizon frames", "");
  const { answer: found, error, isAsking, ask } = useRequest<Found>(null);
  const read = readRequest(request);
  const asked: HorizonRequest | null = typeof read === "string" ? null : read;
  const cameras = asked?.cameras ?? [];

  const [id, setId] = useKept("/horizon plan", wanted ?? "", wanted);
  const kept = useKeptPlan(id);

  const take = (change: (now: File[]) => File[]) =>
    setFrames((now) => {
      const next = change(now);
      setFrameNames(next.map((one) => one.name).join(", "));
      return next;
    });
  const measure = () => {
    if (asked) void ask(async (until) => ({ asked, estimate: await estimate(asked, frames, until) }));
  };
  return (
    <div class="room">
      <h1>{text.shell.rooms.horizon}</h1>
      <p>{text.horizon.what}</p>
      <div class="horizon">
        <section class="panel" aria-labelledby="horizon-frames">
          <h2 id="horizon-frames">{text.horizon.frames}</h2>
          <Frames cameras={cameras.map((camera) => camera.name)} frames={frames} onFrames={take} />
          {frames.length === 0 && frameNames && <p class="hint">{text.shell.fileAgain(frameNames)}</p>}
        </section>
        <section class="panel" aria-labelledby="horizon-request">
          <h2 id="horizon-request">{text.horizon.request}</h2>
          <FromPlan
            id={id}
            onId={setId}
            kept={kept}
            request={asked}
            onRequest={(filled) => setRequest(JSON.stringify(filled, null, 2))}
          />
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
          disabled={isAsking || !asked || frames.length === 0 || frames.length !== cameras.length}
          onClick={measure}
        >
          {text.horizon.measure}
        </button>
        <span role="status">{isAsking ? text.horizon.atWork : text.horizon.count(frames.length, cameras.length)}</span>
      </div>
      {error !== null && <ProblemNotice error={error} again={measure} />}
      {found && <Result found={found.estimate} asked={found.asked} plan={kept.plan} />}
    </div>
  );
}
