import { defineConfig } from 'vitest/config';
import { vda_schemas } from './dev/vda-schemas.mjs';

export default defineConfig({
  plugins: [vda_schemas()],
  server: { fs: { allow: ['..'] } }, // the schemas stand beside the code that writes the messages
  test: { include: ['src/**/*.test.ts'], environment: 'node' },
});
