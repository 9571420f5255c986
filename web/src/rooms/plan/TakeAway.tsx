/** Everything that leaves the page: files, the link, the request in three forms, paper. */
import { download } from "../../api/download";
import { PLAN_FORMATS } from "../../api/lists";
import { useRequest } from "../../api/request";
import { curl, python } from "../../api/snippets";
import { words } from "../../i18n";
import { named } from "../../i18n/forms";
import { Copied } from "../../parts/Copied";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { address } from "../../router";
import { fileNameOf } from "./identity";
import type { Plan } from "./plan";

type Format = (typeof PLAN_FORMATS)[number];

/** Ways by which a plan is asked for: the client's, the page's and the service's, and the room that changes it. */
export interface Asked {
  call: string;
  room: string;
  change: (id: string) => string;
}

interface Props {
  plan: Plan;
  /** As it was sent; null until it is read. */
  request: string | null;
  unread: unknown;
  asked: Asked;
}

export function TakeAway({ plan, request, unread, asked }: Props) {
  const text = words.value.plan.take;
  const saving = useRequest<void>(null);
  const error = saving.error ?? unread;
  const save = (format: Format) => {
    void saving.ask(() =>
      download(
        "/v1/plans/{id}/table",
        { id: plan.id, query: { format } },
        (told) => fileNameOf(plan) + (/\.[^.]+$/.exec(told ?? "")?.[0] ?? `.${format}`),
      ),
    );
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
        {PLAN_FORMATS.filter((format) => format !== "csv").map((format) => (
          <li key={format}>
            <button type="button" class="plain" onClick={() => save(format)}>
              {named(text.formats, format)}
            </button>
          </li>
        ))}
      </ul>
      <Copied name={text.permalink} content={new URL(address(`${asked.room}/${plan.id}`), location.href).href} isOpen />
      {request !== null && (
        <>
          <Copied name={text.request} content={request} />
          <Copied name={text.curl} content={curl(service, request, `v1${asked.room}`)} />
          <Copied name={text.python} content={python(service, request, asked.call)} />
        </>
      )}
    </section>
  );
}
