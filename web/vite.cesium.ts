/** Files that Cesium's engine needs beside its code, without the styles that the content policy refuses. */
import { cpSync, mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

import type { Plugin } from "vite";

const ENGINE = "node_modules/@cesium/engine";
// The Earth's picture, and how high the ground is that lines are laid on.
const ASSETS = ["Textures/NaturalEarthII", "approximateTerrainHeights.json"];
// What draws the CZML of plans and sessions.
const WORKERS = [
  "combineGeometry",
  "createEllipsoidGeometry",
  "createGeometry",
  "createGroundPolylineGeometry",
  "createPolygonGeometry",
  "createPolygonOutlineGeometry",
  "createPolylineGeometry",
  "createSimplePolylineGeometry",
  "createVerticesFromHeightmap",
  "incrementallyBuildTerrainPicker",
  "transferTypedArrayTest",
  "upsampleQuantizedTerrainMesh",
];
// Inline styles, which the content policy refuses: of its credits, where the page names the sources
// itself, and of a trial, which may set its style by script.
const INLINE_STYLES = [
  { file: "Scene/CreditDisplay.js", part: "  appendCss(container);\n", instead: "" },
  { file: "Scene/CreditDisplay.js", part: ' style="vertical-align: -7px"', instead: "" },
  {
    file: "Core/FeatureDetection.js",
    part: 'setAttribute(\n      "style",\n      "image-rendering: -moz-crisp-edges;" + "image-rendering: pixelated;",\n    )',
    instead: 'style.cssText = "image-rendering: pixelated"',
  },
];

export function cesium(outDir: string): Plugin {
  return {
    name: "cesium",
    transform(code, id) {
      const found = INLINE_STYLES.filter(({ file }) => id.endsWith(`engine/Source/${file}`));
      for (const { part, instead } of found) {
        if (!code.includes(part)) this.error("Cesium styles otherwise now: see vite.cesium.ts");
        code = code.replace(part, instead);
      }
      return found.length > 0 ? { code, map: null } : null;
    },
    writeBundle() {
      const to = join(outDir, "assets/cesium");
      for (const asset of ASSETS) {
        cpSync(join(ENGINE, "Source/Assets", asset), join(to, "Assets", asset), { recursive: true });
      }
      mkdirSync(join(to, "Workers"), { recursive: true });
      for (const file of withImports(WORKERS.map((name) => `${name}.js`))) {
        cpSync(join(ENGINE, "Build/Workers", file), join(to, "Workers", file));
      }
    },
  };
}

/** These workers' files and all that they import. */
function withImports(files: string[]): Set<string> {
  const all = new Set(files);
  for (const file of all) {
    const code = readFileSync(join(ENGINE, "Build/Workers", file), "utf8");
    for (const [, name] of code.matchAll(/["']\.\/([\w-]+\.js)["']/g)) all.add(name as string);
  }
  return all;
}
