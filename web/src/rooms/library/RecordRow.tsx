/** One record: what it is, how far it has come, and what can be done with it. */
import { useState } from "preact/hooks";

import { remove } from "../../api/client";
import { untilDone } from "../../api/job";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant, percent, period } from "../../i18n/forms";
import { labelOf, nameOf, targetTold } from "../../i18n/labels";
import { Bar } from "../../parts/Bar";
import { Dialog } from "../../parts/Dialog";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { isAtWork, type Job, type Kind, ROOM_PATHS, SERVICE_PATHS } from "./records";

interface Props {
  job: Job;
  kind: Kind;
  chosen: boolean;
  /** Where two of them can be compared. */
  onChoose?: (id: string, isChosen: boolean) => void;
  /** It has ended, or is no more. */
  onChanged: () => void;
}

export function RecordRow({ job, kind, chosen, onChoose, onChanged }: Props) {
  const text = words.value;
  const [isToDelete, setIsToDelete] = useState(false);
  const atWork = isAtWork(job);
  const { progress } = useRequest<void>(atWork ? `${kind} ${job.id}` : null, async (until, show) => {
    const sent = { path: `${SERVICE_PATHS[kind]}/${job.id}`, id: job.id };
    // However it ends, the list tells.
    await untilDone(sent, (progress) => show({ progress }), until).catch(() => undefined);
    if (!until.aborted) onChanged();
  });
  const removal = useRequest<void>(null, async () => {
    await remove(`${SERVICE_PATHS[kind]}/{id}`, { id: job.id });
    onChanged();
  });
  const drop = () => {
    setIsToDelete(false);
    void removal.ask();
  };
  const label = labelOf(job);
  const state = atWork ? (progress?.state ?? job.state) : job.state;
  return (
    <tr>
      {onChoose && (
        <td>
          <input
            type="checkbox"
            aria-label={text.library.chooseOne(label)}
            checked={chosen}
            disabled={job.state !== "done"}
            onChange={(event) => onChoose(job.id, event.currentTarget.checked)}
          />
        </td>
      )}
      <td>
        <Link to={`${ROOM_PATHS[kind]}/${job.id}`}>{nameOf(job)}</Link>
        {job.revision !== null && job.revision > 1 && (
          <div class="small">
            {text.library.revision(job.revision)}
            {job.revises && onChoose && (
              <>
                {" · "}
                <Link to={`/plans?compare=${job.revises},${job.id}`}>{text.library.withBefore}</Link>
              </>
            )}
          </div>
        )}
      </td>
      <td>
        <span class={`state state-${state}`}>{text.shell.states[state]}</span>
        {atWork && <Bar label={progress?.stage ?? text.library.progress} percent={progress?.percent ?? null} />}
        {job.problem && <div class="small">{words.value.service.told(job.problem.detail)}</div>}
        {removal.error !== null && <ProblemNotice error={removal.error} />}
      </td>
      <td class="mono">{job.start && job.stop ? period(job.start, job.stop).replace(" UTC", "") : "–"}</td>
      <td>{named(job)}</td>
      <td class="number">{percent(job.probability_in_frame)}</td>
      <td class="mono">
        {instant(job.created).slice(0, 16)}
        {job.requested_by && <div class="small">{job.requested_by}</div>}
      </td>
      <td>
        <button
          type="button"
          class="plain"
          aria-label={(atWork ? text.library.cancelOne : text.library.deleteOne)(label)}
          onClick={() => (atWork ? drop() : setIsToDelete(true))}
        >
          {atWork ? text.shell.cancel : text.library.remove}
        </button>
        {isToDelete && (
          <Dialog title={text.library.deleteOne(label)} onClose={() => setIsToDelete(false)}>
            <p>{text.library.noWayBack}</p>
            <div class="row">
              <button type="button" class="primary" onClick={drop}>
                {text.library.remove}
              </button>
              <button type="button" onClick={() => setIsToDelete(false)}>
                {text.library.keep}
              </button>
            </div>
          </Dialog>
        )}
      </td>
    </tr>
  );
}

const NAMED = 3;

function named({ targets, target_count }: Job): string {
  const rest = target_count - Math.min(targets.length, NAMED);
  return targets.slice(0, NAMED).map(targetTold).join("; ") + (rest > 0 ? ` +${rest}` : "");
}
