import { svelte } from '@sveltejs/vite-plugin-svelte';
import { defineConfig } from 'vite';
import { vda_schemas } from './dev/vda-schemas.mjs';

// The page is served by cosiva itself; while developing, /api is answered by a running platform or by dev/mock-server.mjs.
const platform = process.env.COSIVA_URL ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  plugins: [svelte(), vda_schemas()],
  build: {
    // Native private fields: Svelte's state lives in them, and anything older pays for each with a map.
    target: 'es2022',
    outDir: 'dist',
    emptyOutDir: true,
    sourcemap: false,
    modulePreload: false,
    // 6 kB of 120 less than esbuild's.
    minify: 'terser',
    terserOptions: { module: true, ecma: 2020, compress: { passes: 3 }, format: { comments: false } },
  },
  worker: { format: 'es' },
  server: { host: '127.0.0.1', port: 5173, proxy: { '/api': { target: platform, ws: true } } },
});
