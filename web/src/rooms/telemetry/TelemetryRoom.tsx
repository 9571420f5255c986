/** Telemetry beside a kept plan: a CSV is compared with its table. */
import { useEffect, useState } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import { Identity } from "../../parts/Identity";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { checksum } from "../../parts/paper";
import type { RoomProps } from "../../room";
import { place } from "../../router";
import { Axis } from "./Axis";
import { type Compared, compare, requestOf } from "./compare";
import { Samples } from "./Samples";
import "./telemetry.css";

export default function TelemetryRoom(_: RoomProps) {
  const text = words.value;
  const [plan, setPlan] = useState(place.value.query.get("plan") ?? "");
  const [columns, setColumns] = useState("");
  const [file, setFile] = useState<File | null>(null);
  const { answer: found, error, isAsking, ask } = useRequest<Compared>(null);
  useEffect(() => () => void (found && URL.revokeObjectURL(found.picture)), [found]);

  const submit = (event: Event) => {
    event.preventDefault();
    if (file) void ask((until) => compare(requestOf(plan.trim(), columns), file, until));
  };
  return (
    <div class="room">
      <h1>{text.shell.rooms.telemetry}</h1>
      <p>{text.telemetry.what}</p>
      <form class="panel" onSubmit={submit}>
        <Field label={text.telemetry.plan} hint={text.telemetry.planHint}>
          {(control) => <input {...control} required value={plan} onInput={(event) => setPlan(event.currentTarget.value)} />}
        </Field>
        <DropZone label={text.telemetry.file} accept=".csv,.txt,text/csv" onFile={setFile}>
          <p class="small">{file ? file.name : text.telemetry.fileHint}</p>
        </DropZone>
        <Field label={text.telemetry.columns} hint={text.telemetry.columnsHint}>
          {(control) => (
            <input
              {...control}
              value={columns}
              placeholder='{"t_s": "Time", "alpha_deg": "AZ", "beta_deg": "EL"}'
              onInput={(event) => setColumns(event.currentTarget.value)}
            />
          )}
        </Field>
        <button type="submit" class="primary" disabled={!plan.trim() || !file || isAsking}>
          {text.telemetry.compare}
        </button>{" "}
        <span role="status">{isAsking && text.telemetry.atWork}</span>
      </form>
      {error !== null && <ProblemNotice error={error} />}
      {found && <Told found={found} />}
    </div>
  );
}

function Told({ found: { comparison, picture } }: { found: Compared }) {
  const text = words.value.telemetry;
  const { time_offset_s, clock_drift, ideal_offset_s, inseparable } = comparison;
  return (
    <>
      <Identity
        name={comparison.name || comparison.plan}
        parts={[instant(comparison.epoch)]}
        proof={[comparison.plan, checksum(comparison.provenance.input_sha256)]}
      />
      <section class="panel" aria-labelledby="clock" data-testid="comparison">
        <h2 id="clock">{text.clock}</h2>
        <p>
          {text.offset(time_offset_s.value.toFixed(4), time_offset_s.sigma.toFixed(4))}{" "}
          {text.drift((Math.round(1e8 * clock_drift.value) / 100 + 0).toFixed(2), (1e6 * clock_drift.sigma).toFixed(2))}
        </p>
        {ideal_offset_s && <p>{text.ideal(ideal_offset_s.value.toFixed(6), ideal_offset_s.sigma.toFixed(6))}</p>}
        {inseparable.map(({ members }) => (
          <p key={members.join()} class="small">
            {text.inseparable(members.join(", "))}
          </p>
        ))}
        {comparison.warnings.map((warning) => (
          <p key={warning} class="notice notice-warn">
            {warning}
          </p>
        ))}
        <img src={picture} alt={text.picture} class="flight-picture" />
      </section>
      {Object.entries(comparison.axes).map(([name, axis]) => (
        <Axis key={name} name={name} axis={axis} />
      ))}
      <Samples samples={comparison.samples} />
      {comparison.corrections.length > 0 && (
        <details class="panel">
          <summary>{text.corrections}</summary>
          <pre tabIndex={0}>{JSON.stringify(comparison.corrections, null, 2)}</pre>
        </details>
      )}
    </>
  );
}
