/** Files of the API's pages: Swagger UI and ReDoc as they are published, but for what ReDoc would fetch. */
import { cpSync, readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";

import type { Plugin } from "vite";

const REDOC = "node_modules/redoc/bundles/redoc.standalone.js";
const FILES = [
  "node_modules/swagger-ui-dist/swagger-ui-bundle.js",
  "node_modules/swagger-ui-dist/swagger-ui.css",
  "src/shell/icon.svg",
];
// ReDoc's sign beside its name, which it would fetch from elsewhere.
const SIGN = "https://cdn.redoc.ly/redoc/logo-mini.svg";

export function documentation(outDir: string): Plugin {
  const to = (file: string) => join(outDir, "assets/documentation", basename(file));
  return {
    name: "documentation",
    writeBundle() {
      for (const file of FILES) cpSync(file, to(file));
      const redoc = readFileSync(REDOC, "utf8");
      if (!redoc.includes(SIGN)) this.error("ReDoc has its sign from elsewhere now: see vite.documentation.ts");
      writeFileSync(to(REDOC), redoc.replaceAll(SIGN, "data:,"));
    },
  };
}
