/** The library of kept work: the list, or two plans side by side (`?compare=ID,ID`). */
import { words } from "../../i18n";
import type { RoomProps } from "../../room";
import { place } from "../../router";
import { Compared } from "./Compared";
import "./library.css";
import { RecordList } from "./RecordList";

export default function LibraryRoom(_: RoomProps) {
  const [first, second] = place.value.query.get("compare")?.split(",") ?? [];
  const text = words.value;
  return (
    <div class="room">
      <h1>{first && second ? text.library.compared : text.shell.rooms.library}</h1>
      {first && second ? <Compared ids={[first, second]} /> : <RecordList />}
    </div>
  );
}
