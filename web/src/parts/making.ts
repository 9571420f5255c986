/** A request in the making: begun with an example or with one that was sent before, and sent off. */
import { type JobPaths, sendOff } from "../api/job";
import { useRequest } from "../api/request";
import { go, place } from "../router";
import { useStateOf } from "./stateOf";

/** path: of the service; room: of the page, where what is made is shown; before: of an id, the request. */
export function useMaking<R extends object>(
  path: JobPaths,
  room: string,
  example: R,
  before: (id: string, until: AbortSignal) => Promise<R>,
) {
  const from = place.value.query.get("from");
  const begun = useRequest<R>(from, (until) => before(from ?? "", until));
  const [request, setRequest] = useStateOf<R>(begun.answer, () => begun.answer ?? example);
  const sending = useRequest<void>(null);
  const send = () => sending.ask(async (until) => go(`${room}/${(await sendOff(path, request, {}, until)).id}`));
  return { request, setRequest, isSending: sending.isAsking, error: sending.error ?? begun.error, send };
}
