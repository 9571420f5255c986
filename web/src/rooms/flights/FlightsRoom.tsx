import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function FlightsRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.flights}</h1>
    </div>
  );
}
