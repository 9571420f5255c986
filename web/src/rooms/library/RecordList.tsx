/** The list: what is asked of it, its rows, and what can be done with them. */
import { useState } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { Filters } from "./Filters";
import { RecordRow } from "./RecordRow";
import { type Kind, list, type Records, type Wanted } from "./records";

export function RecordList() {
  const text = words.value.library;
  const [kind, setKind] = useState<Kind>("plans");
  const [wanted, setWanted] = useState<Wanted>({});
  const [chosen, setChosen] = useState<string[]>([]);
  const {
    answer: records,
    error,
    ask,
  } = useRequest<Records>(kind, (until) => list(kind, wanted, undefined, until), JSON.stringify(wanted));
  const reload = () => void ask();
  const more = async (until: AbortSignal) => {
    const after = await list(kind, wanted, records?.next ?? "", until);
    return { jobs: [...(records?.jobs ?? []), ...after.jobs], next: after.next };
  };
  const choose = (id: string, isChosen: boolean) =>
    setChosen((before) => [...before.filter((other) => other !== id), ...(isChosen ? [id] : [])].slice(-2));
  const show = (next: Kind) => {
    setKind(next);
    setChosen([]);
  };

  return (
    <>
      <Filters kind={kind} onKind={show} onWanted={setWanted} onReload={reload} />
      {error !== null && <ProblemNotice error={error} again={reload} />}
      {kind === "plans" && (
        <p class="row small">
          {text.chooseTwo(chosen.length)}
          {chosen.length === 2 && (
            <Link to={`/plans?compare=${chosen.join(",")}`} class="button">
              {text.compare}
            </Link>
          )}
        </p>
      )}
      {records?.jobs.length === 0 && <p>{text.none}</p>}
      {records !== null && records.jobs.length > 0 && (
        <div class="scroll-x" tabIndex={0} role="region" aria-label={text.list}>
          <table class="records">
            <thead>
              <tr>
                {kind === "plans" && <th scope="col">{text.choose}</th>}
                <th scope="col">{text.name}</th>
                <th scope="col">{text.state}</th>
                <th scope="col">{text.time}</th>
                <th scope="col">{text.targets}</th>
                <th scope="col" class="number">
                  {text.probability}
                </th>
                <th scope="col">{text.made}</th>
                <th scope="col">
                  <span class="hidden">{text.actions}</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {records.jobs.map((job) => (
                <RecordRow
                  key={job.id}
                  job={job}
                  kind={kind}
                  chosen={chosen.includes(job.id)}
                  onChoose={kind === "plans" ? choose : undefined}
                  onChanged={reload}
                />
              ))}
            </tbody>
          </table>
        </div>
      )}
      {records?.next && (
        <button type="button" onClick={() => void ask(more)}>
          {text.more}
        </button>
      )}
    </>
  );
}
