/** A plan flown many times: asked at /flights, told at /flights/ID. */
import { words } from "../../i18n";
import type { RoomProps } from "../../rooms";
import { Ask } from "./Ask";
import "./flights.css";
import { Flown } from "./Flown";

export default function FlightsRoom({ params }: RoomProps) {
  const text = words.value;
  return (
    <div class="room">
      <h1>{text.shell.rooms.flights}</h1>
      {params.id ? <Flown key={params.id} id={params.id} /> : <Ask />}
    </div>
  );
}
