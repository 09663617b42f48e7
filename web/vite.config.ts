import { svelte } from '@sveltejs/vite-plugin-svelte';
import { defineConfig, type Plugin } from 'vite';
import { vda_schemas } from './dev/vda-schemas.mjs';

// The page is served by cosiva itself; while developing, /api is answered by a running platform or by dev/mock-server.mjs.
const platform = process.env.COSIVA_URL ?? 'http://127.0.0.1:8080';

/** Leaves out of the page what it never uses: words for people in the shaders. */
const leave_out: Plugin = {
  name: 'leave-out',
  enforce: 'pre',
  transform: (code, id) => (id.endsWith('/webgl_shader.ts') ? code.replace(/\/\/[^\n]*/g, '').replace(/\n\s+/g, '\n') : null),
};

/** Loads the later chunks with a bare import(): Vite's own helper only adds their style sheets, and none of them has one. */
const bare_import: Plugin = {
  name: 'bare-import',
  enforce: 'pre',
  load: (id) => (id === '\0vite/preload-helper.js' ? 'export const __vitePreload = (load) => load();' : null),
  generateBundle(_options, bundle) {
    const sheets = Object.keys(bundle).filter((name) => name.endsWith('.css'));
    if (sheets.length > 1) this.error(`A later chunk has a style sheet of its own, which nothing would load: ${sheets.join(', ')}`);
  },
};

export default defineConfig({
  base: './',
  plugins: [leave_out, bare_import, svelte(), vda_schemas()],
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
  server: { host: '127.0.0.1', port: 5173, fs: { allow: ['..'] }, proxy: { '/api': { target: platform, ws: true } } },
});
