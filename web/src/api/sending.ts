/** A request in the making: begun with an example or with one that was sent before, and sent off. */
import { useEffect, useState } from "preact/hooks";

import { go, place } from "../router";
import { type JobPaths, sendOff } from "./job";

interface Making<R> {
  request: R;
  setRequest: (request: R) => void;
  isSending: boolean;
  error: unknown;
  /** Goes to what it makes once the service has taken it. */
  send: () => Promise<void>;
}

/** path: of the service; room: of the page, where what is made is shown; before: of an id, the request. */
export function useMaking<R extends object>(
  path: JobPaths,
  room: string,
  example: R,
  before: (id: string) => Promise<R>,
): Making<R> {
  const [request, setRequest] = useState(example);
  const [isSending, setIsSending] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const from = place.value.query.get("from");
  useEffect(() => {
    if (from) before(from).then(setRequest, setError);
  }, [from]);
  const send = async () => {
    setError(null);
    setIsSending(true);
    try {
      go(`${room}/${(await sendOff(path, request)).id}`);
    } catch (caught) {
      setError(caught);
      setIsSending(false);
    }
  };
  return { request, setRequest, isSending, error, send };
}
