// Bundles src/ and three.js into viewer.js, and writes LICENSES.txt. Run by ./dev viewer; needs node_modules beside it.
// With a folder as argument it writes there instead.

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";

const out = process.argv[2] ?? ".";
const sources = ["build.mjs", "package-lock.json", "package.json", ...readdirSync("src").sort().map((name) => `src/${name}`)];
const digest = createHash("sha256");
for (const name of sources) digest.update(`${name}\0`).update(readFileSync(name)).update("\0");
const { version } = JSON.parse(readFileSync("node_modules/three/package.json", "utf8"));

await build({
  entryPoints: ["src/viewer.js"],
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "casaViewer",
  target: "es2022",
  legalComments: "none",
  charset: "utf8",
  banner: { js: `/* casa-assets viewer with three.js ${version} (MIT, see LICENSES.txt); sources ${digest.digest("hex")} */` },
  outfile: join(out, "viewer.js"),
});
const licence = readFileSync("node_modules/three/LICENSE", "utf8").trim();
writeFileSync(join(out, "LICENSES.txt"), `viewer.js holds code of casa-assets (Apache-2.0, see LICENSE) and of three.js ${version}:\n\n${licence}\n`);
