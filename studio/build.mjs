// Builds the page into a folder, dist/ if none is named: node build.mjs [FOLDER]
import { cp, mkdir } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { join, resolve } from "node:path";
import { build } from "esbuild";

const root = fileURLToPath(new URL(".", import.meta.url));
const out = resolve(process.argv[2] ?? join(root, "dist"));
const notice =
  "/*! klieg studio. With Preact and @preact/signals, (c) Jason Miller and the Preact team, under the MIT licence. */";

await mkdir(out, { recursive: true });
await build({
  absWorkingDir: root,
  entryPoints: [{ in: "src/main.tsx", out: "studio" }, { in: "src/style/studio.css", out: "studio" }],
  outdir: out,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "none",
  banner: { js: notice },
  logLevel: "warning",
});
for (const name of ["index.html", "icon.svg"]) await cp(join(root, "src", name), join(out, name));
