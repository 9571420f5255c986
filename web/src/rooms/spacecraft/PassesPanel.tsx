/** The passes of the next days over what is asked for; a click takes one for the session's times. */
import { useMemo, useState } from "preact/hooks";
import { searchStart } from "../../api/orbit";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { useKept } from "../../parts/kept";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { UtcField } from "../../parts/UtcField";
import { Overview } from "../../windows/Overview";
import { PassFigures } from "../../windows/PassFigures";
import { type Found, findPasses, highest, type Pass, type Search } from "./passes";
import type { SessionRequest } from "./session";

const MOST_DAYS = 14;
const NOTHING = { answer: null, error: null, isAsking: false };

interface Props {
  request: SessionRequest;
  /** How many are asked for. */
  count: number;
  onTimes: (times: { start: string; stop: string }) => void;
}

export function PassesPanel({ request, count, onTimes }: Props) {
  const text = words.value.spacecraft.passes;
  const { span, windows } = words.value.plan;
  const { orbit, spacecraft, settings, requests } = request;
  const [from, setFrom] = useKept<string | null>("/spacecraft passes from", null);
  const [days, setDays] = useKept("/spacecraft passes days", 3);
  const passes = useRequest<Found>(null);
  const [asked, setAsked] = useState<Search | null>(null);
  const start = from ?? new Date(searchStart(orbit, Date.now())).toISOString();
  const search = useMemo<Search>(
    () => ({ orbit, spacecraft, settings, requests, from_ms: Date.parse(start), days }),
    [orbit, spacecraft, settings, requests, start, days],
  );
  // Of another search it tells nothing.
  const { answer: found, error, isAsking } = asked === search ? passes : NOTHING;
  const ask = () => {
    setAsked(search);
    void passes.ask((until) => findPasses(search, until));
  };
  const taken = found?.passes.find((pass) => isOf(pass, request)) ?? null;
  return (
    <section class="panel" aria-labelledby="session-passes">
      <div class="row heading">
        <h2 id="session-passes">{text.title}</h2>
        <span role="status" class="small">
          {isAsking ? text.searching : found ? windows.count(found.passes.length) : ""}
        </span>
      </div>
      <div class="passes-span">
        <UtcField label={span.from} value={start} onValue={setFrom} />
        <Field label={span.days}>
          {(control) => (
            <input
              {...control}
              type="number"
              min={1}
              max={MOST_DAYS}
              value={days}
              onChange={(event) => {
                const given = event.currentTarget.valueAsNumber;
                if (given >= 1 && given <= MOST_DAYS) setDays(given);
              }}
            />
          )}
        </Field>
        <button type="button" disabled={count === 0 || isAsking} onClick={ask}>
          {text.find}
        </button>
      </div>
      {error !== null && <ProblemNotice error={error} again={ask} />}
      {found && found.unseen.length > 0 && <p class="notice notice-warn">{text.unseen(found.unseen.join(", "))}</p>}
      {found && found.passes.length > 0 && (
        <>
          <Overview
            passes={found.opportunities}
            taken={(one) => taken?.seen.includes(one) ?? false}
            from_ms={found.from_ms}
            to_ms={found.to_ms}
            onTake={(one) => {
              const pass = found.passes.find(({ seen }) => seen.includes(one));
              if (pass) onTimes({ start: pass.start, stop: pass.stop });
            }}
          />
          <ul class="window-list" aria-label={text.list} tabIndex={0}>
            {found.passes.map((pass) => (
              <li key={pass.start}>
                <button
                  type="button"
                  class="window"
                  aria-pressed={pass === taken}
                  onClick={() => onTimes({ start: pass.start, stop: pass.stop })}
                >
                  <PassFigures pass={highest(pass)} />
                  <span class="small pass-seen">{told(pass, count)}</span>
                </button>
              </li>
            ))}
          </ul>
        </>
      )}
      {found?.warnings.map((warning) => (
        <p key={warning} class="hint">
          {words.value.service.told(warning)}
        </p>
      ))}
    </section>
  );
}

function isOf(pass: Pass, { start, stop }: SessionRequest): boolean {
  return Date.parse(pass.start) === Date.parse(start) && Date.parse(pass.stop) === Date.parse(stop);
}

/** What a session in the pass can image, and from how far aside. */
function told({ seen }: Pass, count: number): string {
  const text = words.value.spacecraft.passes;
  const across = new Map(seen.map((one) => [one.target, one.closest.angles_deg.across_track]));
  const names = [...across].map(([name, across_deg]) =>
    across_deg == null ? name : text.aside(name, number(Math.round(Math.abs(across_deg)), 0)),
  );
  return `${text.sees(across.size, count)}: ${names.join(", ")}`;
}
