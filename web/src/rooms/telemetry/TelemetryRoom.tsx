/** Telemetry beside a kept plan: a CSV is compared with its table. */
import { useMemo, useState } from "preact/hooks";

import { save } from "../../api/download";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { digits, fixed, period } from "../../i18n/forms";
import { DropZone } from "../../parts/DropZone";
import { Identity } from "../../parts/Identity";
import { useKept } from "../../parts/kept";
import { NextPlan } from "../../parts/NextPlan";
import { PlanField, useKeptPlan } from "../../parts/PlanField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import type { RoomProps } from "../../room";
import { place } from "../../router";
import { fileNameOf, nameOf } from "../plan/identity";
import { isOfBody, type Plan } from "../plan/plan";
import { Axis } from "./Axis";
import { Columns } from "./Columns";
import { meaningsFor, meaningsForBody, namesIn, renamed } from "./columns";
import { type Compared, compare, type ImageOffset } from "./compare";
import { Flight } from "./Flight";
import { Offsets } from "./Offsets";
import { Samples } from "./Samples";
import "./telemetry.css";

export default function TelemetryRoom(_: RoomProps) {
  const text = words.value;
  const asked = place.value.query.get("plan");
  const [id, setId] = useKept("/telemetry plan", asked ?? "", asked);
  const [file, setFile] = useState<File | null>(null);
  const [fileName, setFileName] = useKept("/telemetry file", "", asked);
  const [chosen, setChosen] = useKept<Record<string, string>>("/telemetry columns", {}, asked);
  const [offsets, setOffsets] = useKept<ImageOffset[]>("/telemetry offsets", [], asked);
  const kept = useKeptPlan(id);
  const read = useRequest<string[]>(file && `${file.name} ${file.size} ${file.lastModified}`, () =>
    file ? namesIn(file) : Promise.resolve([]),
  );
  const names = read.answer ?? [];
  const isBody = kept.plan !== null && isOfBody(kept.plan);
  const meanings = useMemo(
    () => (isBody ? meaningsForBody() : meaningsFor(Object.keys(kept.plan?.margins ?? {}))),
    [kept.plan, isBody],
  );
  const { answer: found, error, isAsking, ask } = useRequest<Compared>(null);

  const take = (given: File) => {
    setFile(given);
    setFileName(given.name);
  };
  const submit = (event: Event) => {
    event.preventDefault();
    const seen = isBody ? [] : offsets;
    if (file) void ask((until) => compare({ plan: id, columns: renamed(names, chosen), offsets: seen }, file, until));
  };
  return (
    <div class="room">
      <h1>{text.shell.rooms.telemetry}</h1>
      <p>{text.telemetry.what}</p>
      <form class="panel no-print" onSubmit={submit}>
        <PlanField id={id} onId={setId} kept={kept} />
        <DropZone label={text.telemetry.file} accept=".csv,.txt,text/csv" onFile={take}>
          <p class="small">{file ? file.name : text.telemetry.fileHint}</p>
          {!file && fileName && <p class="hint">{text.shell.fileAgain(fileName)}</p>}
        </DropZone>
        {names.length > 0 && kept.plan && <Columns names={names} meanings={meanings} chosen={chosen} onChosen={setChosen} />}
        {kept.plan && !isBody && <Offsets epoch={kept.plan.summary.start} offsets={offsets} onOffsets={setOffsets} />}
        <button type="submit" class="primary" disabled={!id || !file || isAsking}>
          {text.telemetry.compare}
        </button>{" "}
        <span role="status">{isAsking && text.telemetry.atWork}</span>
      </form>
      {error !== null && <ProblemNotice error={error} />}
      {found && <Told found={found} plan={kept.plan?.id === found.comparison.plan ? kept.plan : null} />}
    </div>
  );
}

function Told({ found, plan }: { found: Compared; plan: Plan | null }) {
  const text = words.value.telemetry;
  const { comparison, flown } = found;
  const { time_offset_s, clock_drift, ideal_offset_s, inseparable, samples, corrections, parameters, platform } = comparison;
  const isBody = plan !== null && isOfBody(plan);
  const drift_ppm = [1e6 * clock_drift.value, 1e6 * clock_drift.sigma].map((ppm) => fixed(ppm, 2));
  return (
    <>
      <Identity
        name={plan ? nameOf(plan) : comparison.name || comparison.plan}
        parts={[text.of, period(samples.start, samples.stop), ...(plan ? [plan.platform] : [])]}
        proof={[comparison.plan, checksum(comparison.provenance.input_sha256)]}
        made={{ at: comparison.provenance.planned_at }}
      />
      <section class="panel" aria-labelledby="clock" data-testid="comparison">
        <h2 id="clock">{text.clock}</h2>
        <p>
          {text.offset(fixed(time_offset_s.value, 4), fixed(time_offset_s.sigma, 4))}{" "}
          {text.drift(drift_ppm[0] ?? "", drift_ppm[1] ?? "")}
        </p>
        {ideal_offset_s && <p>{text.ideal(fixed(ideal_offset_s.value, 6), fixed(ideal_offset_s.sigma, 6))}</p>}
        {inseparable.map(({ members }) => (
          <p key={members.join()} class="small">
            {text.inseparable(members.join(", "))}
          </p>
        ))}
        {comparison.warnings.map((warning) => (
          <p key={warning} class="notice notice-warn">
            {words.value.service.told(warning)}
          </p>
        ))}
      </section>
      <Flight comparison={comparison} flown={flown} />
      {Object.entries(comparison.axes).map(([name, axis]) => (
        <Axis key={name} name={name} axis={axis} hasDrive={!isBody} />
      ))}
      <Samples samples={samples} />
      <section class="panel" aria-labelledby="learnt">
        <h2 id="learnt">{text.learnt}</h2>
        {corrections.length > 0 || platform ? (
          <>
            <NextPlan plan={comparison.plan} learnt={{ corrections, platform }} />
            {parameters.map((one) => (
              <p key={one.name}>
                <code>{one.name}</code>:{" "}
                {text.found(digits(one.found), one.sigma === null ? null : digits(one.sigma), digits(one.planned))}
              </p>
            ))}
            {corrections.length > 0 && (
              <details>
                <summary>{text.corrections}</summary>
                <pre tabIndex={0}>{JSON.stringify(corrections, null, 2)}</pre>
              </details>
            )}
          </>
        ) : (
          <p class="small">{isBody ? text.nothingLearntOfBody : text.nothingLearnt}</p>
        )}
      </section>
      <Export found={found} stem={`${plan ? fileNameOf(plan) : comparison.plan}_telemetry`} />
    </>
  );
}

function Export({ found: { comparison, table, file }, stem }: { found: Compared; stem: string }) {
  const saving = useRequest<void>(null);
  const picture = (format: "png" | "svg") => void saving.ask(async () => save(await file(format), `${stem}.${format}`));
  const numbers = () => save(new Blob([JSON.stringify(comparison, null, 1)], { type: "application/json" }), `${stem}.json`);
  const text = words.value.telemetry;
  return (
    <section class="panel no-print" aria-labelledby="telemetry-export">
      <h2 id="telemetry-export">{words.value.plan.take.title}</h2>
      {saving.error !== null && <ProblemNotice error={saving.error} />}
      <div class="row">
        <button type="button" onClick={() => save(table, `${stem}.csv`)}>
          {text.exports.csv}
        </button>
        <button type="button" onClick={numbers}>
          {text.exports.json}
        </button>
        <button type="button" onClick={() => picture("svg")}>
          {text.exports.svg}
        </button>
        <button type="button" onClick={() => picture("png")}>
          {text.exports.png}
        </button>
        <button type="button" onClick={() => window.print()}>
          {words.value.plan.take.print}
        </button>
      </div>
    </section>
  );
}
