// Headless Chromium with three.js: a server for a page of this folder, and the browser.
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm' };

// The page at /, three of `modules` at /three/, files[i] at /file/i.
export async function serve(modules, page, files) {
  const server = http.createServer((request, response) => {
    const url = new URL(request.url, 'http://localhost');
    let file = path.join(here, page);
    if (url.pathname.startsWith('/three/')) file = path.join(modules, url.pathname);
    if (url.pathname.startsWith('/file/')) file = files[Number(url.pathname.slice(6))];
    fs.readFile(file, (error, data) => {
      // Isolated pages have clocks of 5 microseconds instead of 100.
      response.writeHead(error ? 404 : 200, {
        'content-type': types[path.extname(file)] ?? 'application/octet-stream',
        'cross-origin-opener-policy': 'same-origin', 'cross-origin-embedder-policy': 'require-corp',
      });
      response.end(error ? '' : data);
    });
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { server, address: `http://127.0.0.1:${server.address().port}/` };
}

export function chromium_of(modules) {
  const { chromium } = createRequire(path.resolve(modules, 'x.js'))('playwright-core');
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}
