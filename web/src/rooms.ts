/** The page's rooms: one line each, loaded when it is first gone to. */
import type { ComponentType } from "preact";

import type { Words } from "./i18n";

export interface RoomProps {
  /** What the address names: of "/plans/:id" the id. */
  params: Record<string, string>;
}

export interface Room {
  /** Its first part must be among PAGE_ROOMS in app/http/admission/access.py. */
  path: string;
  /** Its heading, and its name in the menu. */
  title: keyof Words["shell"]["rooms"];
  inMenu?: boolean;
  load: () => Promise<{ default: ComponentType<RoomProps> }>;
}

export const ROOMS: readonly Room[] = [
  { path: "/", title: "plan", inMenu: true, load: () => import("./rooms/plan/AskRoom") },
  { path: "/plans/:id", title: "one", load: () => import("./rooms/plan/PlanRoom") },
  { path: "/plans", title: "kept", inMenu: true, load: () => import("./rooms/kept/KeptRoom") },
  { path: "/campaigns", title: "campaigns", inMenu: true, load: () => import("./rooms/campaigns/CampaignsRoom") },
  { path: "/campaigns/:id", title: "campaigns", load: () => import("./rooms/campaigns/CampaignsRoom") },
  { path: "/spacecraft", title: "spacecraft", inMenu: true, load: () => import("./rooms/spacecraft/SpacecraftRoom") },
  { path: "/spacecraft/plans/:id", title: "spacecraft", load: () => import("./rooms/spacecraft/SpacecraftRoom") },
  { path: "/horizon", title: "horizon", inMenu: true, load: () => import("./rooms/horizon/HorizonRoom") },
  { path: "/flights", title: "flights", inMenu: true, load: () => import("./rooms/flights/FlightsRoom") },
  { path: "/flights/:id", title: "flights", load: () => import("./rooms/flights/FlightsRoom") },
  { path: "/telemetry", title: "telemetry", inMenu: true, load: () => import("./rooms/telemetry/TelemetryRoom") },
];
