/** One campaign: how far it is, what was chosen and why the rest was not. */
import { useState } from "preact/hooks";

import { useJob, useRequest } from "../../api/request";
import { words } from "../../i18n";
import { period } from "../../i18n/forms";
import { nameOf } from "../../i18n/labels";
import { Identity } from "../../parts/Identity";
import { JobState } from "../../parts/JobState";
import { Link } from "../../parts/Link";
import { Notices } from "../../parts/Notices";
import { checksum } from "../../parts/paper";
import { CampaignFiles } from "./CampaignFiles";
import { fatesOf, fetchCampaign, fetchRequest, nameIn, PATH } from "./campaign";
import { FateMap } from "./FateMap";
import { Fates } from "./Fates";
import { Passes } from "./Passes";
import { conditionsTold } from "./WhenAndHow";
import { Worth } from "./Worth";

export function OneCampaign({ id }: { id: string }) {
  const text = words.value.campaigns;
  const job = useJob(PATH, id, fetchCampaign);
  const { answer } = job;
  // Whatever is wrong with the campaign is told by the campaign itself.
  const { answer: request } = useRequest(id, (until) => fetchRequest(id, until));
  const [chosen, setChosen] = useState<string | null>(null);
  const fates = answer && request ? fatesOf(request, answer) : [];
  return (
    <div class="room">
      <div class="row heading">
        <h1>{answer ? nameOf(answer) : words.value.shell.rooms.campaigns}</h1>
        <Link to={`/campaigns?from=${id}`} class="button">
          {words.value.plan.one.change}
        </Link>
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
      <JobState work="/v1/campaigns" room="/campaigns" id={id} job={job} text={text} />
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
      {fates.length > 0 && (
        <div class="seen-beside">
          <FateMap fates={fates} chosen={chosen} onChoose={setChosen} />
          <Fates fates={fates} chosen={chosen} onChoose={setChosen} />
        </div>
      )}
      {answer && answer.passes.length > 0 && <Passes passes={answer.passes} />}
      {request && <CampaignFiles id={id} request={request} hasPlans={answer?.state === "done" && answer.planned.done > 0} />}
    </div>
  );
}
