/** A file with targets, dropped or chosen, and what is missing in one that has none. */
import { useState } from "preact/hooks";

import { words } from "../../i18n";
import { DropZone } from "../../parts/DropZone";
import type { CampaignTarget } from "./campaign";
import { NoTargets, targetsOf } from "./targets";

interface Props {
  text: { choose: string; drop: string };
  accept: string;
  onTargets: (targets: CampaignTarget[]) => void;
}

export function TargetsFile({ text, accept, onTargets }: Props) {
  const [wrong, setWrong] = useState<string | null>(null);
  const take = async (file: File) => {
    try {
      onTargets(targetsOf(await file.text()));
      setWrong(null);
    } catch (caught) {
      if (!(caught instanceof NoTargets)) throw caught;
      setWrong(words.value.campaigns.noTargets(file.name, caught.line, caught.missing));
    }
  };
  return (
    <>
      <DropZone label={text.choose} accept={accept} onFile={(file) => void take(file)}>
        <p class="small">{text.drop}</p>
      </DropZone>
      {wrong !== null && (
        <p class="wrong" role="alert">
          {wrong}
        </p>
      )}
    </>
  );
}
