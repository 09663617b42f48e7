// The page must stay light: everything in dist, gzipped, within 120 kB.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const limit_bytes = 120_000;
const dist = path.join(path.dirname(fileURLToPath(import.meta.url)), '../dist');
let total = 0;
for (const name of readdirSync(dist, { recursive: true })) {
  const file = path.join(dist, String(name));
  if (statSync(file).isFile()) total += gzipSync(readFileSync(file)).length;
}
console.log(`whole page: ${(total / 1000).toFixed(1)} kB gzipped, ${limit_bytes / 1000} kB allowed`);
if (total > limit_bytes) process.exit(1);
