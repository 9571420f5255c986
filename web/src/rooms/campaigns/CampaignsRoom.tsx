/** Many targets over days: asked for at /campaigns, shown at /campaigns/{id}. */
import type { RoomProps } from "../../room";
import { AskCampaign } from "./AskCampaign";
import "./campaigns.css";
import { OneCampaign } from "./OneCampaign";

export default function CampaignsRoom({ params }: RoomProps) {
  return params.id === undefined ? <AskCampaign /> : <OneCampaign id={params.id} />;
}
