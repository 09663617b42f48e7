// The page must stay light: what a browser fetches to show it, gzipped, within 120 kB. What it fetches later,
// for the help, an opened message (with the official schemas), the batteries or the camera's image, is reported separately
// and has its own limit.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const first_limit_bytes = 120_000;
const later_limit_bytes = 33_000;
const dist = path.join(path.dirname(fileURLToPath(import.meta.url)), '../dist');
const html = readFileSync(path.join(dist, 'index.html'), 'utf8');

let first = 0;
let later = 0;
for (const name of readdirSync(dist, { recursive: true })) {
  const file = path.join(dist, String(name));
  if (!statSync(file).isFile()) continue;
  const bytes = gzipSync(readFileSync(file)).length;
  const at_once = name === 'index.html' || html.includes(path.basename(file)) || /^worker/.test(path.basename(file));
  if (at_once) first += bytes;
  else later += bytes;
}
const kB = (bytes) => (bytes / 1000).toFixed(1);
console.log(`the page: ${kB(first)} kB gzipped of ${kB(first_limit_bytes)} allowed, and ${kB(later)} kB of ${kB(later_limit_bytes)} on demand`);
if (first > first_limit_bytes || later > later_limit_bytes) process.exit(1);
