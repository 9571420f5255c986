import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function CampaignsRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.campaigns}</h1>
    </div>
  );
}
