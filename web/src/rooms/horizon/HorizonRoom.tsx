import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function HorizonRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.horizon}</h1>
    </div>
  );
}
