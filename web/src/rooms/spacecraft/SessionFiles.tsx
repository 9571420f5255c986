/** Everything of a session that leaves the page, and what its numbers rest on. */
import { send } from "../../api/client";
import { download } from "../../api/download";
import { SESSION_FORMATS } from "../../api/lists";
import { useRequest } from "../../api/request";
import { curl, python } from "../../api/snippets";
import { words } from "../../i18n";
import { named } from "../../i18n/forms";
import { Copied } from "../../parts/Copied";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { address } from "../../router";

type Format = (typeof SESSION_FORMATS)[number];

export function SessionFiles({ id, assumptions }: { id: string; assumptions: readonly string[] }) {
  const text = words.value.spacecraft;
  const take = words.value.plan.take;
  const { answer: request, error: unread } = useRequest(id, async (until) =>
    (await send("GET", "/v1/spacecraft/plans/{id}/request", { id, signal: until })).text(),
  );
  const saving = useRequest<void>(null);
  const error = saving.error ?? unread;
  // JSON is the plan itself, which holds the table.
  const save = (format: Format) => {
    const path = format === "json" ? "/v1/spacecraft/plans/{id}" : "/v1/spacecraft/plans/{id}/table";
    const given = format === "json" ? { id, headers: { Accept: "application/json" } } : { id, query: { format } };
    void saving.ask(() => download(path, given, (told) => told ?? `session.${format}`));
  };
  const service = new URL(address("/"), location.href).href;
  return (
    <section class="panel" aria-labelledby="session-files">
      <h2 id="session-files">{take.title}</h2>
      {error !== null && <ProblemNotice error={error} />}
      <ul class="session-formats">
        {SESSION_FORMATS.map((format) => (
          <li key={format}>
            <button type="button" onClick={() => save(format)}>
              {format === "json" ? text.everything : named(take.formats, format)}
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
