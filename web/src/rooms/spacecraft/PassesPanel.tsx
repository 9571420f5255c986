/** The passes of the next days over what is asked for; a click takes one for the session's times. */
import { useMemo, useState } from "preact/hooks";
import { searchStart } from "../../api/orbit";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { useKept } from "../../parts/kept";
import { NumberField } from "../../parts/NumberField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { UtcField } from "../../parts/UtcField";
import { WindowList } from "../../windows/WindowList";
import { type Found, findPasses, type Pass, type Search } from "./passes";
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
        <NumberField label={span.days} least={1} most={MOST_DAYS} value={days} onValue={setDays} />
        <button type="button" disabled={count === 0 || isAsking} onClick={ask}>
          {text.find}
        </button>
      </div>
      {error !== null && <ProblemNotice error={error} again={ask} />}
      {found && found.unseen.length > 0 && <p class="notice notice-warn">{text.unseen(found.unseen.join(", "))}</p>}
      {found && found.passes.length > 0 && (
        <WindowList
          windows={found.passes}
          taken={taken}
          from_ms={found.from_ms}
          to_ms={found.to_ms}
          label={text.list}
          onTake={({ session }) => onTimes(session)}
          more={(pass) => <span class="small pass-seen">{told(pass, count)}</span>}
        />
      )}
      {found?.warnings.map((warning) => (
        <p key={warning} class="hint">
          {words.value.service.told(warning)}
        </p>
      ))}
    </section>
  );
}

function isOf({ session }: Pass, { start, stop }: SessionRequest): boolean {
  return Date.parse(session.start) === Date.parse(start) && Date.parse(session.stop) === Date.parse(stop);
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
