/** Targets and requests as dropped files hold them. */
import { readFileSync } from "node:fs";

import { expect, test } from "vitest";

import "./page";

const { NoTargets, targetsOf } = await import("../src/rooms/campaigns/targets");
const { geometryOf, positionsOf } = await import("../src/map/modes");
const { askedOf } = await import("../src/rooms/spacecraft/session");
const { readRequest } = await import("../src/rooms/horizon/estimate");

const OSLO = { id: "Oslo", session_s: 40, target: { mode: "ground", latitude_deg: 59.9, longitude_deg: 10.7, height_m: 0 } };

test.each([
  ["CSV", "name,lat,lon\nOslo,59.9,10.7\n"],
  ["CSV with semicolons, quotes and a byte order mark", '\uFEFF# cities\nCity;Latitude;Longitude\r\n"Oslo";59.9;10.7'],
  ["a list", '[{"id": "Oslo", "latitude_deg": 59.9, "longitude_deg": 10.7}]'],
  ["a request", JSON.stringify({ targets: [OSLO] })],
  ["GeoJSON", '{"features": [{"id": "Oslo", "properties": {}, "geometry": {"type": "Point", "coordinates": [10.7, 59.9]}}]}'],
])("targets of %s", (_, text) => {
  expect(targetsOf(text)).toEqual([OSLO]);
});

test("wishes are read, and places by their names", () => {
  const text = 'id,place,priority,session_s,looks\n"Oslo, twice","Oslo, NO",3,20,2';
  const target = { mode: "place", name: "Oslo, NO" };
  expect(targetsOf(text)).toEqual([{ id: "Oslo, twice", priority: 3, session_s: 20, looks: 2, target }]);
});

test("every field of a target may be a column, and others are left alone", () => {
  const fields = { group: "7", sensor: "infrared", release: "2015-02-27T12:00:00Z", due: "2015-02-27T21:00:00Z" };
  const text = `id,latitude_deg,longitude_deg,population,target,${Object.keys(fields)}\n7,59.9,10.7,700000,Oslo,${Object.values(fields)}\n`;
  expect(targetsOf(text)).toEqual([{ ...OSLO, id: "7", ...fields }]);
  const rolled = "id,target.mode,target.name,roll.rule,roll.azimuth_deg\nVega at noon,star,Vega,azimuth,15\nany,body,Moon,,";
  expect(targetsOf(rolled)).toEqual([
    { id: "Vega at noon", session_s: 40, target: { mode: "star", name: "Vega" }, roll: { rule: "azimuth", azimuth_deg: 15 } },
    { id: "any", session_s: 40, target: { mode: "body", name: "Moon" } },
  ]);
  const cities = targetsOf(readFileSync("../examples/cities.csv", "utf8"));
  const target = { mode: "ground", latitude_deg: 31.22222, longitude_deg: 121.45806, height_m: 25 };
  expect(cities[0]).toEqual({ id: "Shanghai", priority: 2.5, session_s: 30, min_session_s: 15, target });
});

test("shapes of several parts are one target, whose own fields are among its properties", () => {
  const geometry = {
    type: "MultiPolygon",
    coordinates: [
      [
        [
          [0, 0],
          [1, 0],
          [1, 1],
          [0, 0],
        ],
      ],
    ],
  };
  const properties = { name: "isles", due: "2015-02-27T21:00:00Z", overlap: 0.1 };
  expect(targetsOf(JSON.stringify({ type: "Feature", geometry, properties }))).toEqual([
    { id: "isles", due: properties.due, target: { mode: "area", overlap: 0.1, geometry } },
  ]);
});

test.each([
  ["name,lat,lon\nOslo,59.9,10.7\nBergen,,5.3", 3, "latitude_deg"],
  ["name,lat,lon\nOslo,north,10.7", 2, "latitude_deg"],
  ["name,lat,lon", 1, "id, latitude_deg, longitude_deg"],
  ['{"features": [{"geometry": {"type": "MultiPoint"}}]}', 1, "Point, LineString, MultiLineString, Polygon, MultiPolygon"],
  ['{"request": 1}', null, "targets"],
])("a file without targets says where: %s", (text, line, missing) => {
  expect(() => targetsOf(text)).toThrow(expect.objectContaining({ line, missing }));
  expect(() => targetsOf(text)).toThrow(NoTargets);
});

test("lines and polygons are imaging modes, as their properties say or by their shapes", () => {
  const text = readFileSync("../examples/spacecraft_four_modes.geojson", "utf8");
  const targets = targetsOf(text);
  expect(targets.map((one) => one.target.mode).sort()).toEqual(["area", "corridor", "stereo", "strip"]);
  const asked = askedOf({ requests: JSON.parse(text) } as unknown as Parameters<typeof askedOf>[0]);
  expect(asked.map((one) => one.name)).toEqual(targets.map((one) => one.id));
  const line = '{"type": "Feature", "geometry": {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}}';
  expect(targetsOf(line)).toMatchObject([{ id: "strip 1", target: { mode: "strip" } }]);
  const typed = { requests: { features: [{ geometry: null }] } };
  expect(askedOf(typed as unknown as Parameters<typeof askedOf>[0])).toEqual([]);
});

test("positions make a mode's geometry, and are had from it again", () => {
  const corners: [number, number][] = [
    [0, 0],
    [1, 0],
    [1, 1],
  ];
  const area = geometryOf("area", corners);
  expect(area).toEqual({ type: "Polygon", coordinates: [[...corners, [0, 0]]] });
  expect(positionsOf(area)).toEqual(corners);
  expect(positionsOf(geometryOf("corridor", corners))).toEqual(corners);
  expect(positionsOf(null)).toEqual([]);
});

test("a horizon request without cameras is none", () => {
  expect(readRequest('{"cameras": []}')).toEqual({ cameras: [] });
  expect(readRequest("[]")).toBe("cameras?");
  expect(readRequest("{")).toContain("JSON");
});
