import { defineConfig } from 'vitest/config';
import { vda_schemas } from './dev/vda-schemas.mjs';

export default defineConfig({ plugins: [vda_schemas()], test: { include: ['src/**/*.test.ts'], environment: 'node' } });
