/** The globe as the page uses it. */
export interface Place {
  latitude_deg: number;
  longitude_deg: number;
  height_m?: number;
}

export interface GlobeView {
  /** t_s: since the plan's epoch.  sun: the place that has it overhead. */
  show: (t_s: number, sun: Place | null) => void;
  overview: (places: Place[]) => void;
  /** factor: above 1 comes closer; false where it would come closer than its picture is good for. */
  zoom: (factor: number) => boolean;
}

/** Whether this browser draws in three dimensions at all. */
export function hasWebGl(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return context !== null;
}
