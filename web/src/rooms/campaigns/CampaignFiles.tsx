/** Everything of a campaign that leaves the page: its looks as files, its plans as an archive, its request. */
import { download } from "../../api/download";
import { useRequest } from "../../api/request";
import { curl } from "../../api/snippets";
import { words } from "../../i18n";
import { Copied } from "../../parts/Copied";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { address } from "../../router";
import { type AskedCampaign, PATH } from "./campaign";

const FILES = {
  csv: "text/csv",
  geojson: "application/geo+json",
  kml: "application/vnd.google-earth.kml+xml",
  zip: "application/zip",
} as const;

interface Props {
  id: string;
  request: AskedCampaign;
  /** Whether it has ended with plans. */
  hasPlans: boolean;
}

export function CampaignFiles({ id, request, hasPlans }: Props) {
  const text = words.value.campaigns;
  const { take } = words.value.plan;
  const saving = useRequest<void>(null);
  const service = new URL(address("/"), location.href).href;
  return (
    <section class="panel take-away no-print" aria-label={take.title}>
      <h2>{take.title}</h2>
      {saving.error !== null && <ProblemNotice error={saving.error} />}
      <div class="row files">
        {Object.entries(FILES).map(([name, Accept]) => (
          <button
            key={name}
            type="button"
            disabled={!hasPlans}
            onClick={() =>
              void saving.ask(() => download(PATH, { id, headers: { Accept } }, (told) => told ?? `campaign.${name}`))
            }
          >
            {text.files[name as keyof typeof FILES]}
          </button>
        ))}
        <button type="button" onClick={() => window.print()}>
          {take.print}
        </button>
      </div>
      <Copied name={take.permalink} content={new URL(address(`/campaigns/${id}`), location.href).href} />
      <Copied name={take.request} content={JSON.stringify(request, null, 2)} />
      <Copied name={take.curl} content={curl(service, JSON.stringify(request), "v1/campaigns")} />
    </section>
  );
}
