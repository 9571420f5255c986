import type { ComponentChildren } from "preact";

import { Cancelled, type Progress, requestOf, sendOff } from "../api/job";
import { offerOf } from "../api/offer";
import { brokeOff, Problem } from "../api/problem";
import { useRequest } from "../api/request";
import { words } from "../i18n";
import { go } from "../router";
import { AtWork } from "./AtWork";
import { ProblemNotice } from "./ProblemNotice";
import { TakeOffer } from "./TakeOffer";

interface Props {
  /** That shows it, by the path at which the service takes such work. */
  room: "/campaigns" | "/spacecraft/plans";
  id: string;
  error: unknown;
  /** Fetches it once more. */
  again: () => void;
  text: Told;
}

interface Told {
  cancelled: string;
  gone: string;
  stages: Record<string, string>;
}

interface Job {
  answer: unknown;
  error: unknown;
  progress: Progress | null;
  ask: () => Promise<unknown>;
  cancel: () => void;
}

/** How far a job is, or why it came to nothing, and the way on; the room's heading has the link that changes the request. */
export function JobState({
  job,
  text,
  children,
  ...asked
}: Pick<Props, "room" | "id"> & { job: Job; text: Told; children?: ComponentChildren }) {
  const { answer, error, progress } = job;
  return (
    <>
      {error !== null && <JobEnded {...asked} error={error} again={() => void job.ask()} text={text} />}
      {!answer && !progress && error === null && <p class="loading">{words.value.shell.loading}</p>}
      {progress && (
        <AtWork progress={progress} stages={text.stages} onCancel={job.cancel}>
          {children}
        </AtWork>
      )}
    </>
  );
}

function JobEnded({ room, id, error, again, text }: Props) {
  const work = `/v1${room}` as const;
  const anew = useRequest<void>(null);
  const askFor = (changes: object) =>
    anew.ask(async (until) => {
      const request = await requestOf<object>(work, id, until);
      go(`${room}/${(await sendOff(work, { ...request, ...changes }, {}, until)).id}`);
    });
  const told = error instanceof Cancelled ? text.cancelled : error instanceof Problem && error.status === 404 ? text.gone : null;
  if (told !== null) {
    return (
      <p class="notice" role="status">
        {told}
      </p>
    );
  }
  const offer = offerOf(error);
  const once = brokeOff(error) ? () => void askFor({}) : again;
  return (
    <>
      <ProblemNotice error={error} again={once}>
        {offer && <TakeOffer offer={offer} take={() => void askFor({ start: offer.start, stop: offer.stop })} />}
      </ProblemNotice>
      {anew.error !== null && <ProblemNotice error={anew.error} />}
    </>
  );
}
