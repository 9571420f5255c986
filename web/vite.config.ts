import { defineConfig } from "vite";

import { cesium } from "./vite.cesium.ts";
import { documentation } from "./vite.documentation.ts";
import { licences } from "./vite.licences.ts";

const OUT = "../app/http/page";

// Addresses stay relative: the service sets <base>, so that the page works under a proxy's path.
export default defineConfig({
  base: "./",
  plugins: [cesium(OUT), documentation(OUT), licences(OUT)],
  build: {
    outDir: OUT,
    emptyOutDir: true,
    assetsInlineLimit: 0, // fonts and pictures are files, as the content policy wants them
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 6000, // Cesium's engine, loaded after the rest
    target: "es2022",
  },
  server: { proxy: { "/v1": "http://127.0.0.1:8000", "/docs": "http://127.0.0.1:8000" } },
});
