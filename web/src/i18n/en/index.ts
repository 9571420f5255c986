import { campaigns } from "./campaigns";
import { flights } from "./flights";
import { horizon } from "./horizon";
import { kept } from "./kept";
import { look } from "./look";
import { plan } from "./plan";
import { shell } from "./shell";
import { spacecraft } from "./spacecraft";
import { telemetry } from "./telemetry";

export const EN = {
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
