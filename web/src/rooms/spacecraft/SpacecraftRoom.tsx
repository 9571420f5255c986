/** Sessions of the imaging spacecraft: asked for at /spacecraft, shown at /spacecraft/plans/{id}. */
import type { RoomProps } from "../../room";
import { AskSession } from "./AskSession";
import { OneSession } from "./OneSession";
import "./spacecraft.css";

export default function SpacecraftRoom({ params }: RoomProps) {
  return params.id === undefined ? <AskSession /> : <OneSession id={params.id} />;
}
