/** The plan in space: on the globe where the browser can, on a flat map where it can't. */
import { useSignalEffect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import type { Opened } from "../../globe/engine";
import { hasWebGl, type Place } from "../../globe/globe";
import { words } from "../../i18n";
import { cursor_s } from "../../time/cursor";
import { FlatMap } from "./FlatMap";
import { footprintAt, footprintRows, linesOf } from "./ground";
import { targetAt } from "./Readout";
import { fetchCzml, longitudeAt, rowAt, type View, valueAt } from "./view";

type State = "loading" | "there" | "none";

const DRAWN_EVERY = 40; // rows, to find the middle of the track by

export function Scene({ view }: { view: View }) {
  const text = words.value.viewer.scene;
  const [isFlat, setIsFlat] = useState(() => !hasWebGl());
  const [state, setState] = useState<State>("loading");
  const [isWhole, setIsWhole] = useState(false);
  const box = useRef<HTMLDivElement>(null);
  const globe = useRef<Opened | null>(null);
  useEffect(() => {
    const element = box.current;
    if (isFlat || !element) return;
    const wanted = new AbortController();
    const goFlat = (error: unknown) => {
      if (wanted.signal.aborted) return;
      console.warn(error);
      setState("none");
      setIsFlat(true);
    };
    setState("loading");
    open(view, element, goFlat, wanted.signal).then((opened) => {
      if (!opened) return;
      if (wanted.signal.aborted) return opened.close();
      globe.current = opened;
      opened.overview(track(view));
      opened.show(cursor_s.peek(), sunAt(view, cursor_s.peek()));
      setState("there");
    }, goFlat);
    return () => {
      wanted.abort();
      globe.current?.close();
      globe.current = null;
    };
  }, [view, isFlat]);
  useSignalEffect(() => {
    const t_s = cursor_s.value;
    globe.current?.show(t_s, sunAt(view, t_s));
  });
  const closer = () => {
    const place = targetPlace(view) ?? boresightPlace(view);
    if (place) globe.current?.lookAt(place);
  };
  const canFly = !isFlat && state === "there";
  return (
    <section class="panel look-scene" aria-label={text.title}>
      {isFlat ? (
        <FlatMap view={view} isWhole={isWhole} />
      ) : (
        <div class="look-globe" ref={box} role="img" aria-label={text.told} data-state={state}>
          {state === "loading" && <p class="look-globe-loading">{text.loading}</p>}
        </div>
      )}
      <div class="look-scene-tools">
        {canFly && (
          <>
            <button type="button" onClick={() => globe.current?.overview(track(view))}>
              {text.overview}
            </button>
            <button type="button" onClick={closer}>
              {text.target}
            </button>
            <button type="button" aria-label={text.closer} onClick={() => globe.current?.zoom(1.5)}>
              +
            </button>
            <button type="button" aria-label={text.farther} onClick={() => globe.current?.zoom(1 / 1.5)}>
              −
            </button>
          </>
        )}
        {isFlat && (
          <button type="button" aria-pressed={isWhole} onClick={() => setIsWhole(!isWhole)}>
            {text.world}
          </button>
        )}
        <button type="button" disabled={isFlat && (state === "none" || !hasWebGl())} onClick={() => setIsFlat(!isFlat)}>
          {isFlat ? text.globe : text.map}
        </button>
        <span class="look-credit">{isFlat ? text.mapCredit : text.globeCredit}</span>
      </div>
    </section>
  );
}

/** null where nobody waits for it any more. */
async function open(
  view: View,
  element: HTMLElement,
  onBroken: (error: unknown) => void,
  until: AbortSignal,
): Promise<Opened | null> {
  const [{ openGlobe }, czml] = await Promise.all([import("../../globe/engine"), fetchCzml(view.id, until)]);
  if (until.aborted) return null;
  const swath = footprintRows(view).map((row) => footprintAt(view, row));
  const onGround = { trace: linesOf(view.boresight), swath: swath.filter((outline) => outline.length > 0) };
  return openGlobe(element, czml, Date.parse(view.epoch), onGround, onBroken, until);
}

function track(view: View): Place[] {
  const { latitude_deg, longitude_deg, height_m } = view.carrier;
  return latitude_deg.flatMap((latitude, row) => {
    const longitude = longitude_deg[row];
    if (row % DRAWN_EVERY !== 0 || latitude === null || longitude == null) return [];
    return [{ latitude_deg: latitude, longitude_deg: longitude, height_m: height_m[row] ?? 0 }];
  });
}

function sunAt(view: View, t_s: number): Place | null {
  const [latitude, longitude] = [valueAt(view, view.sun.latitude_deg, t_s), longitudeAt(view, view.sun.longitude_deg, t_s)];
  return latitude === null || longitude === null ? null : { latitude_deg: latitude, longitude_deg: longitude };
}

function targetPlace(view: View): Place | null {
  const row = rowAt(view, cursor_s.peek());
  const target = targetAt(view, row) ?? view.targets[0];
  const [latitude, longitude] = [target?.latitude_deg[row], target?.longitude_deg[row]];
  return latitude == null || longitude == null ? null : { latitude_deg: latitude, longitude_deg: longitude };
}

function boresightPlace(view: View): Place | null {
  const row = rowAt(view, cursor_s.peek());
  const [latitude, longitude] = [view.boresight.latitude_deg[row], view.boresight.longitude_deg[row]];
  return latitude == null || longitude == null ? null : { latitude_deg: latitude, longitude_deg: longitude };
}
