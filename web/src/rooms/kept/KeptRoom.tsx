/** What is kept: the list, or two plans side by side (`?compare=ID,ID`). */
import { words } from "../../i18n";
import { place } from "../../router";
import type { RoomProps } from "../../rooms";
import { Compared } from "./Compared";
import "./kept.css";
import { RecordList } from "./RecordList";

export default function KeptRoom(_: RoomProps) {
  const [first, second] = place.value.query.get("compare")?.split(",") ?? [];
  const text = words.value;
  return (
    <div class="room">
      <h1>{first && second ? text.kept.compared : text.shell.rooms.kept}</h1>
      {first && second ? <Compared ids={[first, second]} /> : <RecordList />}
    </div>
  );
}
