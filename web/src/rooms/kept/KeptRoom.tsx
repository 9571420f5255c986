import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function KeptRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.kept}</h1>
    </div>
  );
}
