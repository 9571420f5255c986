/** The page's rooms: one line each, loaded when it is first gone to. */
import type { ComponentType } from "preact";

import type { Words } from "./i18n/words";
import type { RoomProps } from "./room";

export interface Room {
  /** Its first part must be among PAGE_ROOMS in app/http/admission/access.py. */
  path: string;
  /** Its heading, and its name in the menu. */
  title: keyof Words["shell"]["rooms"];
  inMenu?: boolean;
  load: () => Promise<{ default: ComponentType<RoomProps> }>;
}

export const ROOMS: readonly Room[] = [
  { path: "/", title: "plan", inMenu: true, load: () => import("./rooms/planning/AskRoom") },
  { path: "/plans/:id", title: "onePlan", load: () => import("./rooms/plan/PlanRoom") },
  { path: "/plans", title: "library", inMenu: true, load: () => import("./rooms/library/LibraryRoom") },
  { path: "/timeline", title: "timeline", inMenu: true, load: () => import("./rooms/timeline/TimelineRoom") },
  { path: "/campaigns", title: "campaigns", inMenu: true, load: () => import("./rooms/campaigns/CampaignsRoom") },
  { path: "/campaigns/:id", title: "campaigns", load: () => import("./rooms/campaigns/CampaignsRoom") },
  { path: "/spacecraft", title: "spacecraft", inMenu: true, load: () => import("./rooms/spacecraft/AskSession") },
  { path: "/spacecraft/plans/:id", title: "spacecraft", load: () => import("./rooms/spacecraft/OneSession") },
  { path: "/horizon", title: "horizon", inMenu: true, load: () => import("./rooms/horizon/HorizonRoom") },
  { path: "/flights", title: "simulation", inMenu: true, load: () => import("./rooms/simulation/SimulationRoom") },
  { path: "/flights/:id", title: "simulation", load: () => import("./rooms/simulation/SimulationRoom") },
  { path: "/telemetry", title: "telemetry", inMenu: true, load: () => import("./rooms/telemetry/TelemetryRoom") },
];
