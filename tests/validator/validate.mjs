// Validates glTF files with the Khronos validator and prints one JSON array: for each file its
// name, the numbers of issues by severity, and the issues.
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import validator from "gltf-validator";

const reports = [];
for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(join(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, messages } = issues;
  reports.push({ file, errors: numErrors, warnings: numWarnings, infos: numInfos, messages });
}
console.log(JSON.stringify(reports));
