/** The plan in space: on the globe, close to a target on a flat map, among the stars on a chart of the sky. */
import { useSignalEffect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import type { Opened } from "../../globe/engine";
import { hasWebGl, type Place } from "../../globe/globe";
import { words } from "../../i18n";
import { cursor_s } from "../../time/cursor";
import { FlatMap, type Reach } from "./FlatMap";
import { footprintAt, footprintRows, linesOf } from "./ground";
import { SkyChart } from "./SkyChart";
import { fetchCzml, hasPlaces, longitudeAt, type View, valueAt } from "./view";

type State = "loading" | "there" | "none";
type Picture = "globe" | "map" | "sky";

const DRAWN_EVERY = 40; // rows, to find the middle of the track by
const CLOSER = 1.5;

export function Scene({ view }: { view: View }) {
  const text = words.value.viewer.scene;
  const { sky } = view;
  const [isAble] = useState(hasWebGl);
  const [picture, setPicture] = useState<Picture>(() => (isOfSky(view) ? "sky" : isAble ? "globe" : "map"));
  const [state, setState] = useState<State>("loading");
  const [reach, setReach] = useState<Reach>("pass");
  const [closer, setCloser] = useState(1);
  const box = useRef<HTMLDivElement>(null);
  const globe = useRef<Opened | null>(null);
  useEffect(() => {
    const element = box.current;
    if (picture !== "globe" || !element) return;
    const wanted = new AbortController();
    const goFlat = (error: unknown) => {
      if (wanted.signal.aborted) return;
      console.warn(error);
      setState("none");
      setPicture("map");
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
  }, [view, picture]);
  useSignalEffect(() => {
    const t_s = cursor_s.value;
    globe.current?.show(t_s, sunAt(view, t_s));
  });
  const show = (next: Picture, of: Reach = "pass") => {
    setPicture(next);
    setReach(of);
    setCloser(1);
  };
  const zoom = (factor: number) => {
    if (picture !== "globe") setCloser((before) => Math.min(Math.max(before * factor, 1), 4000));
    // Closer than that the globe's picture shows nothing.
    else if (globe.current?.zoom(factor) === false) show("map", "target");
  };
  const overview = () => {
    if (picture === "globe") globe.current?.overview(track(view));
    else show(picture, "pass");
  };
  const others = (["globe", "map", "sky"] as const).filter((one) => one !== picture && (one !== "sky" || sky));
  return (
    <section class="panel look-scene" aria-label={text.title}>
      {picture === "sky" && sky && <SkyChart view={view} sky={sky} closer={closer} />}
      {picture === "map" && <FlatMap view={view} reach={reach} closer={closer} />}
      {picture === "globe" && (
        <div class="look-globe" ref={box} role="img" aria-label={text.told} data-state={state}>
          {state === "loading" && <p class="look-globe-loading">{text.loading}</p>}
        </div>
      )}
      <div class="look-scene-tools">
        {(picture !== "globe" || state === "there") && (
          <>
            <button type="button" onClick={overview}>
              {text.overview}
            </button>
            {picture !== "sky" && hasPlaces(view) && (
              <button type="button" aria-pressed={picture === "map" && reach === "target"} onClick={() => show("map", "target")}>
                {text.target}
              </button>
            )}
            {picture === "map" && (
              <button type="button" aria-pressed={reach === "world"} onClick={() => show("map", "world")}>
                {text.world}
              </button>
            )}
            <button type="button" aria-label={text.closer} onClick={() => zoom(CLOSER)}>
              +
            </button>
            <button type="button" aria-label={text.farther} onClick={() => zoom(1 / CLOSER)}>
              −
            </button>
          </>
        )}
        {others.map((one) => (
          <button key={one} type="button" disabled={one === "globe" && (state === "none" || !isAble)} onClick={() => show(one)}>
            {text.pictures[one]}
          </button>
        ))}
        <span class="look-credit">{text.credits[picture]}</span>
      </div>
    </section>
  );
}

/** Whether nothing on the Earth is looked at. */
function isOfSky(view: View): boolean {
  return view.sky !== null && !hasPlaces(view);
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
