/** Everything of a session that leaves the page, and what its numbers rest on. */
import { useEffect, useState } from "preact/hooks";

import { send } from "../../api/client";
import { download } from "../../api/download";
import { curl, python } from "../../api/snippets";
import { words } from "../../i18n";
import { Copied } from "../../parts/Copied";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { address } from "../../router";

/** Formats of the table, and how their files' names end. */
const ENDINGS = {
  csv: "csv",
  json: "json",
  netcdf: "nc",
  aem: "aem",
  czml: "czml",
  geojson: "geojson",
  kml: "kml",
  png: "png",
  svg: "svg",
} as const;
type Format = keyof typeof ENDINGS;

export function SessionFiles({ id, assumptions }: { id: string; assumptions: readonly string[] }) {
  const text = words.value.spacecraft;
  const take = words.value.plan.take;
  const [error, setError] = useState<unknown>(null);
  const [request, setRequest] = useState<string | null>(null);
  useEffect(() => {
    send("GET", "/v1/spacecraft/plans/{id}/request", { id })
      .then((answer) => answer.text())
      .then(setRequest, setError);
  }, [id]);
  const save = (format: Format) => {
    setError(null);
    // JSON is the plan itself, which holds the table.
    const path = format === "json" ? "/v1/spacecraft/plans/{id}" : "/v1/spacecraft/plans/{id}/table";
    const given = format === "json" ? { id, headers: { Accept: "application/json" } } : { id, query: { format } };
    download(path, given, `session.${ENDINGS[format]}`).catch(setError);
  };
  const service = new URL(address("/"), location.href).href;
  return (
    <section class="panel" aria-labelledby="session-files">
      <h2 id="session-files">{take.title}</h2>
      {error !== null && <ProblemNotice error={error} />}
      <ul class="session-formats">
        {(Object.keys(ENDINGS) as Format[]).map((format) => (
          <li key={format}>
            <button type="button" onClick={() => save(format)}>
              {text.formats[format]}
            </button>
          </li>
        ))}
      </ul>
      <Copied name={take.permalink} content={new URL(address(`/spacecraft/plans/${id}`), location.href).href} />
      {request !== null && (
        <>
          <Copied name={take.request} content={request} />
          <Copied name={take.curl} content={curl(service, request, "v1/spacecraft/plans")} />
          <Copied name={take.python} content={python(service, request, "spacecraft.plan")} />
        </>
      )}
      <details class="copied">
        <summary>
          <h3>{text.assumptions}</h3>
        </summary>
        <ul>
          {assumptions.map((one) => (
            <li key={one}>{one}</li>
          ))}
        </ul>
      </details>
    </section>
  );
}
