/** Names on maps, the ellipse on the ground. */
import { geoDistance } from "d3-geo";
import { expect, test } from "vitest";

import "./page";

const { placeNames } = await import("../src/map/labels");
const { ellipseAt } = await import("../src/rooms/viewer/ground");
type View = Parameters<typeof ellipseAt>[0];

test("a name stands beside its mark, off all marks and names, and is left out where there is no room", () => {
  type Point = readonly [number, number];
  const place = (...points: (Point | null)[]) =>
    placeNames(
      points,
      points.map(() => "name"),
      400,
    );
  expect(place([50, 50])[0]).toMatchObject({ x: 10, "text-anchor": "start" });
  expect(place([390, 50])[0]).toMatchObject({ x: -10, "text-anchor": "end" }); // the edge
  // Another mark on its right, then on both sides.
  expect(place([100, 50], [125, 50])[0]).toMatchObject({ "text-anchor": "end" });
  expect(place([100, 50], [125, 50], [75, 50])[0]).toMatchObject({ "text-anchor": "middle", y: 21 });
  const crowd = Array.from({ length: 25 }, (_, k): Point => [100 + 14 * (k % 5), 100 + 14 * Math.floor(k / 5)]);
  expect(place(...crowd)[12]).toBeNull();
  expect(place(null, [50, 50])[0]).toBeNull();
});

test("a name as long as the map lies on no mark, be it far from where the name begins", () => {
  const long = (y: number) =>
    placeNames(
      [
        [5, 50],
        [900, y],
      ],
      ["n".repeat(140), ""],
      1000,
    )[0];
  expect(long(50)).toBeNull();
  expect(long(70)).toMatchObject({ "text-anchor": "start", y: 4 });
});

const KM_PER_DEG = 111.195;

test("seen from straight above, the ellipse is as long as height and angle make it", () => {
  // A frame of 2 by 1 deg from 400 km, its first side to the east, its second to the north, on the equator.
  const half = (angle_deg: number) => (400 * Math.tan((angle_deg * Math.PI) / 360)) / KM_PER_DEG;
  const [u, v] = [half(2), half(1)];
  const view = {
    footprint: {
      longitude_deg: [[179.99 + u, 179.99 - u, 179.99 - u, 179.99 + u].map((one) => ((one + 540) % 360) - 180)],
      latitude_deg: [[v, v, -v, -v]],
    },
    pointing: { sigma_major_arcsec: [600], sigma_minor_arcsec: [300], major_turn_deg: [90] },
    frame_deg: [2, 1],
    session: [0],
    targets: [{ session: 0, longitude_deg: [179.99], latitude_deg: [0.01] }],
  } as unknown as View;
  const ring = ellipseAt(view, 0);
  const away_km = ring.map((point) => ((geoDistance([179.99, 0.01], point) * 180) / Math.PI) * KM_PER_DEG);
  const expected = (arcsec: number) => 400 * Math.tan(((arcsec / 3600) * Math.PI) / 180);
  // The tangent of the frame's half is laid out evenly: 1e-4 of it.
  expect(Math.max(...away_km)).toBeCloseTo(expected(600), 3);
  expect(Math.min(...away_km)).toBeCloseTo(expected(300), 3);
  // Turned by 90 deg from the first side towards the second: the long axis points north.
  const farthest = ring[away_km.indexOf(Math.max(...away_km))] ?? [0, 0];
  expect(Math.abs(farthest[0])).toBeCloseTo(179.99, 4);
  expect(ellipseAt({ ...view, pointing: { ...view.pointing, sigma_major_arcsec: [null] } }, 0)).toEqual([]);
});
