/** One campaign: how far it is, what was chosen and why the rest was not. */
import { useState } from "preact/hooks";

import { type Progress, requestOf } from "../../api/job";
import { useJob, useRequest } from "../../api/request";
import { words } from "../../i18n";
import { digits, percent, period } from "../../i18n/forms";
import { nameOf } from "../../i18n/labels";
import { Identity } from "../../parts/Identity";
import { JobState } from "../../parts/JobState";
import { Link } from "../../parts/Link";
import { Notices } from "../../parts/Notices";
import { checksum } from "../../parts/paper";
import { CampaignFiles } from "./CampaignFiles";
import { Carriers } from "./Carriers";
import { type AskedCampaign, coloursOf, fatesOf, fatesWith, fetchCampaign, nameIn, PATH } from "./campaign";
import { FateMap } from "./FateMap";
import { Fates } from "./Fates";
import { Passes } from "./Passes";
import { conditionsTold } from "./WhenAndHow";
import { Worth } from "./Worth";

export function OneCampaign({ id }: { id: string }) {
  const text = words.value.campaigns;
  const job = useJob(PATH, id, fetchCampaign);
  const { answer, progress } = job;
  // Whatever is wrong with the campaign is told by the campaign itself.
  const { answer: request } = useRequest(id, (until) => requestOf<AskedCampaign>("/v1/campaigns", id, until));
  const [chosen, setChosen] = useState<string | null>(null);
  const [sought, setSought] = useState("");
  const [only, setOnly] = useState<string | null>(null);
  const all = answer && request ? fatesOf(request, answer) : [];
  const fates = fatesWith(all, sought, only);
  const colours = coloursOf(answer?.choice ?? null);
  return (
    <div class="room">
      <div class="row heading">
        <h1>{answer ? nameOf(answer) : words.value.shell.rooms.campaigns}</h1>
        <Link to={`/campaigns?from=${id}`} class="button">
          {words.value.plan.one.change}
        </Link>
        {answer?.state === "done" && (
          <Link to={`/campaigns?from=${id}&revises=${id}`} class="button">
            {text.revise}
          </Link>
        )}
      </div>
      {answer?.start && answer.stop && (
        <Identity
          name={nameOf(answer)}
          parts={[period(answer.start, answer.stop), answer.platform, ...(request ? conditionsTold(request) : [])].filter(
            (part) => part !== null,
          )}
          proof={[id, checksum(answer.input_sha256)]}
          made={{ at: answer.created, by: answer.requested_by }}
        />
      )}
      <JobState room="/campaigns" id={id} job={job} text={text}>
        {progress?.value !== undefined && <p data-testid="campaign-so-far">{text.soFar(...soFar(progress))}</p>}
      </JobState>
      {answer?.choice && <Worth choice={answer.choice} planned={answer.planned} targets={answer.target_count} />}
      {answer?.choice && (
        <>
          <Notices
            label={text.assumed}
            kind=""
            told={answer.choice.assumed.map(({ field, detail }) => text.taken(nameIn(request, field), detail))}
          />
          <Notices label={words.value.plan.one.warnings} told={answer.choice.warnings.map(words.value.service.told)} />
        </>
      )}
      {colours.size > 0 && answer?.start && answer.stop && (
        <Carriers
          colours={colours}
          fates={fatesWith(all, sought, null)}
          start={answer.start}
          stop={answer.stop}
          chosen={chosen}
          onChoose={setChosen}
          only={only}
          onOnly={setOnly}
        />
      )}
      {all.length > 0 && (
        <div class="seen-beside">
          <FateMap fates={fates} chosen={chosen} onChoose={setChosen} colours={colours} />
          <Fates fates={fates} chosen={chosen} onChoose={setChosen} sought={sought} onSought={setSought} />
        </div>
      )}
      {answer && answer.passes.length > 0 && <Passes passes={answer.passes} />}
      {request && <CampaignFiles id={id} request={request} hasPlans={answer?.state === "done" && answer.planned.done > 0} />}
    </div>
  );
}

/** The worth of the best choice so far, and once it is proven the bound, and the gap to it. */
function soFar({ value = 0, bound }: Progress): [string, string | null, string | null] {
  if (bound === undefined) return [digits(value, 4), null, null];
  return [digits(value, 4), digits(bound, 4), percent(bound > 0 ? Math.max(0, 1 - value / bound) : 0)];
}
