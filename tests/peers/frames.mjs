// node frames.mjs MODULES FILE.glb FILE.glb...: the files in three.js in headless Chromium, from fixed poses of the first
// one's box (2 outside, 9 inside). For each further file: the mean difference of its pictures from the first one's (share
// of full scale), and milliseconds a frame: of script, with draws cut to one triangle, and of all CPU that the
// browser spends on whole frames, software rasteriser included. MODULES: a node_modules folder with three and playwright-core. One line of
// JSON for each file. --frames N: least frames of each of three turns (default 2); 0: pictures only. --pictures DIR keeps them.
import fs from 'node:fs';
import path from 'node:path';
import { chromium_of, serve } from './viewer.mjs';

const words = process.argv.slice(2);
const take = (name, fallback) => {
  const at = words.indexOf(name);
  return at < 0 ? fallback : words.splice(at, 2)[1];
};
const frames = Number(take('--frames', '2')), keep = take('--pictures', '');
const SCRIPT_FRAMES = 30, ROUNDS = 3, LEAST_MILLISECONDS = 100;
const [modules, ...files] = words;
const { server, address } = await serve(modules, 'frames.html', files);
const browser = await chromium_of(modules);
const page = await browser.newPage();
page.setDefaultTimeout(600000);
const messages = [];
page.on('console', (m) => { if (m.type() !== 'log' && !/GPU stall|favicon|404/.test(m.text())) messages.push(m.text()); });
page.on('pageerror', (e) => messages.push(String(e)));
await page.goto(address, { timeout: 180000 });
await page.waitForFunction('window.ready === true', null, { timeout: 180000 });

// Mean over pixels and channels of the difference of two pictures, decoded by the browser.
const difference = (a, b) => page.evaluate(async ([x, y]) => {
  const pixels = async (url) => {
    const image = new Image();
    image.src = url;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height).data;
  };
  const [p, q] = [await pixels(x), await pixels(y)];
  let sum = 0;
  for (let i = 0; i < p.length; ++i) if (i % 4 !== 3) sum += Math.abs(p[i] - q[i]);
  return sum / (p.length * 0.75 * 255);
}, [a, b]);

// Milliseconds that all processes of the browser have computed: scripts and, in software, the drawing.
const session = await browser.newBrowserCDPSession();
const cpu = async () => {
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  return 1000 * processInfo.reduce((sum, one) => sum + one.cpuTime, 0);
};

let first = [], count = 0;
const rows = [];
for (const [index, file] of files.entries()) {
  const row = { file };
  rows.push(row);
  try {
    count = await page.evaluate(`openFile('/file/${index}')`);
    const pictures = [];
    for (let i = 0; i < count; ++i) {
      pictures.push(await page.evaluate(`picture(${i})`));
      if (keep) fs.writeFileSync(path.join(keep, `${index}_${i}.png`), Buffer.from(pictures[i].split(',')[1], 'base64'));
    }
    if (index === 0) first = pictures;
    else {
      const all = [];
      for (let i = 0; i < count; ++i) all.push(await difference(first[i], pictures[i]));
      row.difference = Math.max(...all);
    }
  } catch (error) {
    row.error = String(error).split('\n')[0];
  }
  row.messages = messages.splice(0).slice(0, 3);
}
// The files by turns, so that what else the machine does falls on all of them: medians of ROUNDS at each pose.
const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
if (frames > 0 && !rows.some((row) => row.error)) {
  for (const row of rows) row.inside = { script: 0, cpu: 0, draws: 0, triangles: 0 };
  for (let i = 2; i < count; ++i) {
    const spent = rows.map(() => ({ script: [], cpu: [] }));
    for (let round = 0; round < ROUNDS; ++round) {
      for (const [index, row] of rows.entries()) {
        await page.evaluate(`use(${index})`);
        const one = await page.evaluate(`measure(${i}, ${SCRIPT_FRAMES})`);
        const before = await cpu();
        const drawn = await page.evaluate(`draw(${i}, ${frames}, ${LEAST_MILLISECONDS})`);
        spent[index].cpu.push((await cpu() - before) / drawn);
        spent[index].script.push(one.script);
        if (round === 0) for (const key of ['draws', 'triangles']) row.inside[key] += one[key] / (count - 2);
      }
    }
    for (const [index, row] of rows.entries())
      for (const key of ['script', 'cpu']) row.inside[key] += median(spent[index][key]) / (count - 2);
  }
}
for (const row of rows) console.log(JSON.stringify(row));
await browser.close();
server.close();
