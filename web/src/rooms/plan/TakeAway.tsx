/** Everything that leaves the page: files, the link, the request in three forms, paper. */
import { useEffect, useState } from "preact/hooks";

import { send } from "../../api/client";
import { download } from "../../api/download";
import type { operations } from "../../api/schema";
import { curl, python } from "../../api/snippets";
import { words } from "../../i18n";
import { Copied } from "../../parts/Copied";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { address } from "../../router";
import type { Plan } from "./plan";

type Format = NonNullable<NonNullable<operations["get_plan_table"]["parameters"]["query"]>["format"]>;

const ENDINGS: Record<Format, string> = {
  csv: "csv",
  json: "json",
  netcdf: "nc",
  aem: "aem",
  oem: "oem",
  stk: "sp",
  "stk-attitude": "a",
  czml: "czml",
  geojson: "geojson",
  kml: "kml",
  png: "png",
  svg: "svg",
};
const FORMATS = Object.keys(ENDINGS) as Format[];

export function TakeAway({ plan }: { plan: Plan }) {
  const text = words.value.plan.take;
  const [error, setError] = useState<unknown>(null);
  const [request, setRequest] = useState<string | null>(null);
  useEffect(() => {
    send("GET", "/v1/plans/{id}/request", { id: plan.id })
      .then((answer) => answer.text())
      .then(setRequest, setError);
  }, [plan.id]);
  const save = (format: Format) => {
    setError(null);
    download("/v1/plans/{id}/table", { id: plan.id, query: { format } }, `plan.${ENDINGS[format]}`).catch(setError);
  };
  const service = new URL(address("/"), location.href).href;
  return (
    <section class="panel take" aria-label={text.title}>
      <h2>{text.title}</h2>
      {error !== null && <ProblemNotice error={error} />}
      <div class="row">
        <button type="button" class="primary" onClick={() => save("csv")}>
          {text.csv}
        </button>
        <button type="button" onClick={() => window.print()}>
          {text.print}
        </button>
      </div>
      <h3>{text.files}</h3>
      <ul class="formats">
        {FORMATS.filter((format) => format !== "csv").map((format) => (
          <li key={format}>
            <button type="button" class="plain" onClick={() => save(format)}>
              {text.formats[format]}
            </button>
          </li>
        ))}
      </ul>
      <Copied name={text.permalink} content={new URL(address(`/plans/${plan.id}`), location.href).href} isOpen />
      {request !== null && (
        <>
          <Copied name={text.request} content={request} />
          <Copied name={text.curl} content={curl(service, request)} />
          <Copied name={text.python} content={python(service, request)} />
        </>
      )}
    </section>
  );
}
