/** The licences of all packages that the page ships, in one file beside it. */
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import type { Plugin } from "vite";

interface Locked {
  version: string;
  license?: string;
  dev?: boolean;
}

const TEXTS = /^(licen[cs]e|notice|copying)|\.LICENSE\.txt$/i;
// For packages that name a licence without its text.
const STANDARD: Record<string, () => string> = {
  MIT: () => readFileSync("node_modules/preact/LICENSE", "utf8").replace(/^[\s\S]*?(?=Permission is hereby)/, ""),
  "Apache-2.0": () => readFileSync("node_modules/swagger-ui-dist/LICENSE", "utf8"),
};

export function licences(outDir: string): Plugin {
  const packages = shipped();
  return {
    name: "licences",
    generateBundle() {
      for (const id of this.getModuleIds()) {
        const [folder] = /node_modules\/(?:@[^/]+\/)?[^/]+(?=\/(?!.*node_modules\/))/.exec(id) ?? [];
        if (folder && ![...packages.keys()].some((one) => one.endsWith(folder)))
          this.error(`${id} is shipped: make its package a dependency`);
      }
    },
    writeBundle() {
      mkdirSync(join(outDir, "assets"), { recursive: true });
      writeFileSync(join(outDir, "assets/licences.txt"), [...packages].map(told).join("\n"));
    },
  };
}

/** By folder: the lock's packages but those that only build. */
function shipped(): Map<string, Locked> {
  const { packages } = JSON.parse(readFileSync("package-lock.json", "utf8")) as { packages: Record<string, Locked> };
  return new Map(Object.entries(packages).filter(([folder, { dev }]) => folder && !dev));
}

function told([folder, { version, license }]: [string, Locked]): string {
  const name = folder.replace(/^.*node_modules\//, "");
  const texts = readdirSync(folder)
    .filter((file) => TEXTS.test(file))
    .map((file) => readFileSync(join(folder, file), "utf8"));
  if (texts.length === 0) {
    const standard = STANDARD[license ?? ""];
    if (!standard) throw new Error(`${name} ${version} comes without the text of its licence, ${license}`);
    const { author } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8")) as { author?: string | { name: string } };
    texts.push(`By ${(typeof author === "object" ? author.name : author) ?? `the authors of ${name}`}.\n\n${standard()}`);
  }
  return `${"=".repeat(72)}\n${name} ${version}${license ? `: ${license}` : ""}\n${"=".repeat(72)}\n\n${texts.map((text) => text.trim()).join("\n\n")}\n`;
}
