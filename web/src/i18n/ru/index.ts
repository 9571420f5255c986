import type { Words } from "../words";
import { campaigns } from "./campaigns";
import { fields } from "./fields";
import { horizon } from "./horizon";
import { library } from "./library";
import { plan } from "./plan";
import { service } from "./service";
import { shell } from "./shell";
import { simulation } from "./simulation";
import { spacecraft } from "./spacecraft";
import { telemetry } from "./telemetry";
import { timeline } from "./timeline";
import { viewer } from "./viewer";

export const RU: Words = {
  campaigns,
  simulation,
  fields,
  horizon,
  library,
  viewer,
  plan,
  service,
  shell,
  spacecraft,
  telemetry,
  timeline,
};
