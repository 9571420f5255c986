import { campaigns } from "./campaigns";
import { horizon } from "./horizon";
import { library } from "./library";
import { plan } from "./plan";
import { shell } from "./shell";
import { simulation } from "./simulation";
import { spacecraft } from "./spacecraft";
import { telemetry } from "./telemetry";
import { timeline } from "./timeline";
import { viewer } from "./viewer";

export const EN = {
  campaigns,
  simulation,
  horizon,
  library,
  viewer,
  plan,
  shell,
  spacecraft,
  telemetry,
  timeline,
};
