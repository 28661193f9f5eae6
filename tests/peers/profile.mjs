// node profile.mjs MODULES: measures what a draw, a change of state, a vertex and a triangle cost in three.js, and prints a
// profile for `lightbatch bake --profile FILE`. MODULES: a node_modules folder with three and playwright-core. Measures in
// headless Chromium (software: no GPU's vertices); with --serve it prints an address to open in the browser to be measured.
import { chromium_of, serve } from './viewer.mjs';

const words = process.argv.slice(2).filter((word) => word !== '--serve');
const { server, address } = await serve(words[0], 'profile.html', []);
if (process.argv.includes('--serve')) {
  console.log(address);
} else {
  const browser = await chromium_of(words[0]);
  const page = await browser.newPage();
  await page.goto(address, { timeout: 180000 });
  await page.waitForFunction('window.profile !== undefined', null, { timeout: 300000 });
  console.log(JSON.stringify(await page.evaluate('window.profile')));
  await browser.close();
  server.close();
}
