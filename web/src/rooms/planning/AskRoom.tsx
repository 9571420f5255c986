/** The request of a plan: orbit, targets, sessions in their windows. */
import { batch } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";

import { get, remove } from "../../api/client";
import { FIELDS } from "../../api/fields";
import { Cancelled, type Progress, type Sent, sendOff, untilDone } from "../../api/job";
import { isAbort, NoAnswer, Problem } from "../../api/problem";
import { useRequest } from "../../api/request";
import { stageText } from "../../api/stage";
import { words } from "../../i18n";
import { wantOutlines } from "../../map/outlines";
import { Bar } from "../../parts/Bar";
import { FormSurroundings } from "../../parts/fields/Fields";
import { faultTold, pathTold } from "../../parts/fields/labels";
import { faultsOf } from "../../parts/fields/shape";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { RoomProps } from "../../room";
import { go, place } from "../../router";
import { fetchPlan, isPlan, type PlanRequest } from "../plan/plan";
import { AttitudePanel } from "./AttitudePanel";
import * as draft from "./draft";
import { OptionsPanel } from "./OptionsPanel";
import { OrbitPanel } from "./OrbitPanel";
import "./planning.css";
import { axes, others, twoAxes } from "./platforms";
import { RefusalNotice } from "./RefusalNotice";
import { RequestPanel } from "./RequestPanel";
import { failure, refused } from "./refusal";
import { SequencePanel, takeOffered } from "./SequencePanel";
import { TargetPanel } from "./TargetPanel";
import { BODIES } from "./target";
import { WindowsPanel } from "./WindowsPanel";
import { WorldMap } from "./WorldMap";
import { keepSearching } from "./windows";

/** Whether the work may go on although nothing more was heard of it. */
function isFromSight(error: unknown): boolean {
  return error instanceof NoAnswer || (error instanceof Problem && (error.status === 429 || error.status === 503));
}

/** Why it came to nothing, and the session it is about, so that it is drawn. */
function fail(error: unknown): void {
  batch(() => {
    failure.value = error;
    if (refused.value && refused.value.session < draft.sessions.value.length) draft.chosen.value = refused.value.session;
  });
}

/** The first thing without which there is nothing to plan. */
function missingTold(): string {
  const text = words.value.plan;
  const all = draft.sessions.value;
  const number = all.findIndex((one) => !one.target || !one.start || !one.stop);
  const session = text.refusal.session(number + 1);
  return `${session}: ${all[number]?.target ? text.sequence.noTimes : text.sequence.noTarget}`;
}

/** Whether the page was loaded at this very address with a draft kept from before. */
let wasReloaded = draft.wasKept && performance.getEntriesByType("navigation")[0]?.name === location.href;

function sameRequest(asked: object): boolean {
  return JSON.stringify(asked) === JSON.stringify(draft.made.peek());
}

export default function AskRoom(_: RoomProps) {
  const text = words.value;
  const [progress, setProgress] = useState<Progress | null>(null);
  const [sent, setSent] = useState<Sent | null>(null);
  const told = useRef<HTMLDivElement>(null);
  const work = useRef(new AbortController());
  /** What was sent off and lost from sight. */
  const lost = useRef<{ asked: string; sent: Sent } | null>(null);
  useEffect(() => () => work.current.abort(), []);
  useEffect(() => void wantOutlines().catch(() => undefined), []); // a map without coasts is still one
  useEffect(() => keepSearching(), []);
  const isReloaded = useRef(wasReloaded);
  wasReloaded = false;
  const { query } = place.value;
  const from = query.get("from");
  const search = query.get("search");
  const isToPlan = query.has("plan");
  const isRevision = query.has("revises"); // of a plan that was made
  const loading = useRequest<void>(from ?? search, async (until) => {
    if (search !== null) {
      const searched = await get("/v1/opportunities/{id}/request", { id: search, signal: until });
      if (until.aborted) return;
      draft.loadWindow(searched as unknown as draft.SearchRequest, Object.fromEntries(query));
      fail(null);
      go("/", { replace: true }); // loaded anew, the page keeps what was changed since
      return;
    }
    const given = { id: from ?? "", signal: until };
    const [asked, job] = await Promise.all([
      get("/v1/plans/{id}/request", given),
      isRevision ? null : fetchPlan(given.id, until),
    ]);
    if (until.aborted) return;
    // Reloaded, the form has what was changed since.
    const isChanged = isReloaded.current && draft.loaded.value === from;
    isReloaded.current = false;
    if (!isChanged) draft.load(asked as unknown as PlanRequest, isRevision ? from : null, from);
    const problem = job && !isPlan(job) && (!isChanged || sameRequest(asked)) ? job.problem : null;
    fail(problem ? new Problem(problem) : null);
    if (!isToPlan) return;
    go(`/?from=${from}`, { replace: true }); // loaded anew, the page doesn't plan again
    if (refused.value?.offered) takeOffered(() => void plan());
    else void plan();
  });

  const plan = async () => {
    failure.value = null;
    work.current = new AbortController();
    const until = work.current.signal;
    setProgress({ state: "queued", stage: null, percent: null });
    try {
      const query: Record<string, string> = draft.revises.value ? { revises: draft.revises.value } : {};
      const asked = JSON.stringify([query, draft.request.value]);
      const before = lost.current?.asked === asked ? lost.current.sent : null;
      const made = before ?? (await sendOff("/v1/plans", draft.request.value, query, until));
      setSent(made);
      lost.current = { asked, sent: made };
      await untilDone(made, setProgress, until);
      lost.current = null;
      draft.revises.value = null;
      go(`/plans/${made.id}`);
    } catch (error) {
      if (isAbort(error)) return;
      if (!isFromSight(error)) lost.current = null;
      if (!(error instanceof Cancelled)) fail(error);
      // Once it is drawn: the form may be longer than the screen.
      requestAnimationFrame(() => told.current?.scrollIntoView({ block: "nearest" }));
    } finally {
      setProgress(null);
      setSent(null);
      // The button that was pressed has lost the focus: whoever goes by Tab goes on from here.
      if (document.activeElement === document.body) told.current?.focus({ preventScroll: true });
    }
  };
  const cancel = () => sent && void remove("/v1/plans/{id}", { id: sent.id }).catch((error: unknown) => (failure.value = error));
  const problem = failure.value instanceof Problem ? failure.value : null;
  const surroundings = {
    axes: axes.value,
    known: { body: BODIES, park: Object.keys(twoAxes.value?.park_positions_deg ?? {}) },
    others: others.value,
    refused: problem?.field ? { path: problem.field, why: words.value.service.told(problem.document.detail) } : null,
  };
  const faults = faultsOf(FIELDS, "PlanRequest", draft.request.value);
  const toMend = faults.filter(({ fault }) => fault.kind !== "missing");
  if (loading.isAsking) return <p class="loading">{text.shell.loading}</p>;
  return (
    <div class="room ask">
      <h1 class="hidden">{text.shell.rooms.plan}</h1>
      <div class="ask-form">
        {loading.error !== null && <ProblemNotice error={loading.error} again={() => void loading.ask()} />}
        <FormSurroundings.Provider value={surroundings}>
          <RequestPanel />
          <OrbitPanel />
          <AttitudePanel />
          <TargetPanel />
          <SequencePanel plan={() => void plan()} />
          <OptionsPanel />
        </FormSurroundings.Provider>
        <div class="ask-told" ref={told} tabIndex={-1}>
          <RefusalNotice plan={() => void plan()} />
        </div>
        <div class="ask-go">
          <div class="row">
            <button
              type="button"
              class="primary big"
              disabled={progress !== null || !draft.isComplete.value}
              onClick={() => void plan()}
            >
              {text.plan.plan}
            </button>
            {progress && (
              <>
                <Bar label={stageText(progress)} percent={progress.percent} />
                <button type="button" onClick={cancel} disabled={!sent}>
                  {text.shell.cancel}
                </button>
              </>
            )}
            {!draft.isComplete.value && <span class="small">{missingTold()}</span>}
            {toMend.map(({ path, fault }) => (
              <span key={path} class="wrong">
                {pathTold("PlanRequest", draft.request.value, path)}: {faultTold(fault)}
              </span>
            ))}
          </div>
        </div>
      </div>
      <div class="ask-view">
        <WorldMap />
        <WindowsPanel />
      </div>
    </div>
  );
}
