import { campaigns } from "./campaigns";
import { flights } from "./flights";
import { horizon } from "./horizon";
import { kept } from "./kept";
import { look } from "./look";
import { plan } from "./plan";
import { shell } from "./shell";
import { spacecraft } from "./spacecraft";
import { telemetry } from "./telemetry";
import type { Words } from "..";

export const RU: Words = {
  campaigns,
  flights,
  horizon,
  kept,
  look,
  plan,
  shell,
  spacecraft,
  telemetry,
};
