/** A campaign's request, while its platform is changed. */
import { afterEach, expect, test } from "vitest";

import "./page";

import example from "../../examples/campaign_cities.json";

const { coloursOf, fatesWith, placesOf, withPlatform } = await import("../src/rooms/campaigns/campaign");
const { platforms } = await import("../src/parts/platforms");
type Request = Parameters<typeof withPlatform>[0] & Parameters<typeof placesOf>[0];
type Found = Parameters<typeof withPlatform>[2];
type Fates = Parameters<typeof fatesWith>[0];

const usual = { usual_yaw_pitch_roll_deg: [-4, -2, 1] };
const axes = { kind: "two_axis", name: "iss-hrc", ...usual } as unknown as Found;
const body = { kind: "body", name: "smallsat-120kg" } as unknown as Found;

afterEach(() => {
  platforms.value = null;
});

test("what only two axes have is set aside for a body, and is there again for them", () => {
  platforms.value = [axes, body];
  const asked = {
    ...example,
    rest_angles_deg: { alpha: 5, beta: -3 },
    slew: { objective: "minimum_time", keep_out: [{ body: "sun", half_angle_deg: 25 }] },
  } as unknown as Request;
  const { attitude: _, rest_angles_deg: __, ...rest } = asked;
  const ofBody = withPlatform(asked, "smallsat-120kg", body, null);
  expect(ofBody).toEqual({ ...rest, platform: "smallsat-120kg", slew: { objective: "minimum_time" } });
  expect(withPlatform(ofBody, "iss-hrc", axes, asked)).toEqual(asked);
  const { attitude, rest_angles_deg } = withPlatform(ofBody, "iss-hrc", axes, null);
  expect([attitude, rest_angles_deg]).toEqual([{ law: "lvlh", yaw_deg: -4, pitch_deg: -2, roll_deg: 1 }, undefined]);
});

test("a platform that is written out keeps the rest of the request, of either kind", () => {
  platforms.value = [axes, body];
  const asked = { ...example, rest_angles_deg: { alpha: 5, beta: -3 } } as unknown as Request;
  expect(withPlatform(asked, axes, axes, asked)).toEqual({ ...asked, platform: axes });
  const ofBody = withPlatform(asked, body, body, null);
  expect(withPlatform(ofBody, { ...body }, body, asked)).toEqual(ofBody);
});

test("an imaging mode lies in the middle of its lines, also across the edge of the map", () => {
  const line = {
    type: "LineString",
    coordinates: [
      [179, 10],
      [-179, 12],
    ],
  };
  const area = {
    type: "Polygon",
    coordinates: [
      [
        [10, 40],
        [14, 40],
        [14, 46],
        [10, 46],
        [10, 40],
      ],
    ],
  };
  const targets = [
    { id: "line", target: { mode: "strip", geometry: line } },
    { id: "area", target: { mode: "area", geometry: area } },
    { id: "half typed", target: { mode: "area", geometry: { type: "Polygon" } } },
  ];
  const asked = { ...example, targets } as unknown as Request;
  expect(placesOf(asked, null)).toEqual([[-180, 11], [12, 43], null]);
});

test("targets are shown by a part of their name, and of one carrier those it looks at", () => {
  const fate = (id: string, ...carriers: string[]) => ({ id, looks: carriers.map((carrier) => ({ carrier })) });
  const fates = [fate("Las Vegas", "north"), fate("Los Angeles", "south", "north"), fate("Boston")] as unknown as Fates;
  const shown = (text: string, carrier: string | null) => fatesWith(fates, text, carrier).map(({ id }) => id);
  expect(shown("", null)).toEqual(["Las Vegas", "Los Angeles", "Boston"]);
  expect(shown(" lAs", null)).toEqual(["Las Vegas"]);
  expect(shown("", "north")).toEqual(["Las Vegas", "Los Angeles"]);
  expect(shown("angeles", "south")).toEqual(["Los Angeles"]);
  expect(shown("boston", "south")).toEqual([]);
});

test("each of several carriers has a colour of its own; one has none", () => {
  const carriers = Array.from({ length: 100 }, (_, number) => ({ id: `c${number}` }));
  const colours = coloursOf({ carriers } as unknown as Parameters<typeof coloursOf>[0]);
  expect(new Set(colours.values()).size).toBe(100);
  expect(coloursOf({} as unknown as Parameters<typeof coloursOf>[0]).size).toBe(0);
  expect(coloursOf(null).size).toBe(0);
});
