import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";

export default function TelemetryRoom(_: RoomProps) {
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.telemetry}</h1>
    </div>
  );
}
