import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function SpacecraftRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.spacecraft}</h1>
    </div>
  );
}
