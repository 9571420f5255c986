/** A request in the making: begun with an example or with one that was sent before, kept, and sent off. */
import { useLayoutEffect, useRef } from "preact/hooks";

import { requestOf, sendOff } from "../api/job";
import { useRequest } from "../api/request";
import { go, place } from "../router";
import { useBegun } from "./kept";
import { useStateOf } from "./stateOf";

/** room: where what is made is shown, by the service's own path. */
export function useMaking<R extends object>(room: "/campaigns" | "/spacecraft/plans", example: R) {
  const path = `/v1${room}` as const;
  const from = place.value.query.get("from");
  const [kept, keep] = useBegun<R>(room, from);
  const begun = useRequest<R>(kept ? null : from, (until) => requestOf(path, from ?? "", until));
  const first = kept ?? begun.answer;
  const [request, setRequest] = useStateOf<R>(first, () => first ?? example);
  const shown = useRef(request);
  // As soon as it is shown, before a reload can come: what a room can't show is not kept.
  useLayoutEffect(() => {
    if (request !== shown.current && request !== begun.answer && !begun.isAsking) keep(request);
    shown.current = request;
  }, [request]);
  const sending = useRequest<void>(null);
  const send = (query: Record<string, string> = {}, members: Partial<R> = {}) =>
    sending.ask(async (until) => go(`${room}/${(await sendOff(path, { ...request, ...members }, query, until)).id}`));
  return { request, setRequest, isSending: sending.isAsking, error: sending.error ?? begun.error, send };
}
