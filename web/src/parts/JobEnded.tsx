import { send } from "../api/client";
import { Cancelled, sendOff } from "../api/job";
import { offerOf } from "../api/offer";
import { brokeOff, Problem } from "../api/problem";
import { useRequest } from "../api/request";
import { go } from "../router";
import { ProblemNotice } from "./ProblemNotice";
import { TakeOffer } from "./TakeOffer";

interface Props {
  /** Where the service takes such work, "/v1/campaigns", and the room that asks for it and shows it. */
  work: "/v1/campaigns" | "/v1/spacecraft/plans";
  room: "/campaigns" | "/spacecraft/plans";
  id: string;
  error: unknown;
  /** Fetches it once more. */
  again: () => void;
  text: { cancelled: string; gone: string };
}

/** Why a job came to nothing, and the way on; the room's heading has the link that changes the request. */
export function JobEnded({ work, room, id, error, again, text }: Props) {
  const anew = useRequest<void>(null);
  const askFor = (changes: object) =>
    anew.ask(async (until) => {
      const request = (await (await send("GET", `${work}/{id}/request`, { id, signal: until })).json()) as object;
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
