import type { ComponentType } from "preact";
import { useEffect, useErrorBoundary, useRef, useState } from "preact/hooks";

import { waiting } from "../api/client";
import { part } from "../api/part";
import { words } from "../i18n";
import { Link } from "../parts/Link";
import { subject } from "../parts/paper";
import type { RoomProps } from "../room";
import { ROOMS, type Room } from "../rooms";
import { address, match, place } from "../router";
import { Header } from "./Header";
import { KeyDialog } from "./KeyDialog";

export function App() {
  const text = words.value.shell;
  const main = useRef<HTMLElement>(null);
  const [room, params] = find(place.value.path);
  const shown = useRef(place.value.path);
  void subject.value;
  useEffect(() => {
    // Where the focus was is gone with the room that was left.
    if (shown.current !== place.value.path && document.activeElement === document.body)
      main.current?.focus({ preventScroll: true });
    shown.current = place.value.path;
  }, [place.value.path]);
  useEffect(() => {
    document.title = [subject.value, room && text.rooms[room.title], "slewtrack"].filter(Boolean).join(" · ");
  });
  return (
    <>
      <button type="button" class="skip" onClick={() => main.current?.focus()}>
        {text.skip}
      </button>
      <Header />
      <Waits />
      <main ref={main} tabIndex={-1}>
        {room ? <Opened key={room.path} room={room} params={params} /> : <NotThere />}
      </main>
      <footer class="foot">
        <a href={address("/assets/licences.txt")}>{text.licences}</a>
      </footer>
      <KeyDialog />
    </>
  );
}

/** Said while the page waits for its next try. */
function Waits() {
  const text = words.value.shell.problem;
  const now = waiting.value;
  if (!now) return null;
  const { left_s, problem } = now;
  const why =
    problem === null ? text.noAnswer : problem.kind === "store-unavailable" ? text.kinds["store-unavailable"] : text.busy;
  return (
    <p class="busy" role="status">
      {text.nextTry(why, left_s)}
    </p>
  );
}

function find(path: string): [Room | null, Record<string, string>] {
  for (const room of ROOMS) {
    const params = match(room.path, path);
    if (params) return [room, params];
  }
  return [null, {}];
}

function Opened({ room, params }: { room: Room; params: Record<string, string> }) {
  const text = words.value.shell;
  const [Content, setContent] = useState<ComponentType<RoomProps> | null>(null);
  const [isLost, setIsLost] = useState(false);
  const [error, reset] = useErrorBoundary((what) => console.error(what));
  const load = () => {
    setIsLost(false);
    part(room.load).then(
      (module) => setContent(() => module.default),
      () => setIsLost(true),
    );
  };
  useEffect(load, [room]);
  if (isLost) return <Again told={text.problem.noAnswer} again={load} />;
  if (error) return <Again told={text.broken} again={reset} />;
  if (!Content) return <p class="loading">{text.loading}</p>;
  return <Content params={params} />;
}

function Again({ told, again }: { told: string; again: () => void }) {
  return (
    <div class="notice notice-error" role="alert">
      <p>{told}</p>
      <button type="button" onClick={again}>
        {words.value.shell.again}
      </button>
    </div>
  );
}

function NotThere() {
  const text = words.value.shell;
  return (
    <div class="room">
      <h1>{text.notThere}</h1>
      <p>
        <Link to="/">{text.toStart}</Link>
      </p>
    </div>
  );
}
