// node validate.mjs FILE.glb: the Khronos validator's count of errors and warnings as JSON, with the codes of both.
import fs from 'node:fs';
import validator from 'gltf-validator';

const bytes = new Uint8Array(fs.readFileSync(process.argv[2]));
const report = await validator.validateBytes(bytes, { maxIssues: 0, externalResourceFunction: () => Promise.reject(new Error('none')) });
const codes = {};
for (const message of report.issues.messages) {
  if (message.severity <= 1) codes[message.code] = (codes[message.code] ?? 0) + 1;
}
console.log(JSON.stringify({ errors: report.issues.numErrors, warnings: report.issues.numWarnings, codes }));
