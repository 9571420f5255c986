/** A plan flown many times: asked at /flights, told at /flights/ID. */
import { words } from "../../i18n";
import type { RoomProps } from "../../room";
import { AskSimulation } from "./AskSimulation";
import "./simulation.css";
import { OneSimulation } from "./OneSimulation";

export default function SimulationRoom({ params }: RoomProps) {
  const text = words.value;
  return (
    <div class="room">
      <h1>{text.shell.rooms.simulation}</h1>
      {params.id ? <OneSimulation key={params.id} id={params.id} /> : <AskSimulation />}
    </div>
  );
}
