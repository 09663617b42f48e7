// Common to the page's benchmarks: metrics of a list, a table, a program that ends with its caller.
import { finally_do } from '../../e2e/lib/cleanup.mjs';
import { writeFileSync } from 'node:fs';

/** Replaces a test: resources that `run` opened are closed when `run` ends, however it ends. */
export async function with_cleanup(run) {
  const actions = [];
  const t = { after: (action) => actions.push(action) };
  finally_do(t, () => {});
  const stop = async () => {
    for (const action of actions.splice(0)) await action();
  };
  for (const signal of ['SIGINT', 'SIGTERM']) process.once(signal, () => stop().finally(() => process.exit(130)));
  try {
    return await run(t);
  } finally {
    await stop();
  }
}

export function quantile(values, q) {
  if (values.length === 0) return NaN;
  const sorted = Float64Array.from(values).sort();
  return sorted[Math.min(sorted.length - 1, Math.max(0, Math.ceil(q * sorted.length) - 1))];
}

export function figures(values) {
  return { count: values.length, p50: quantile(values, 0.5), p99: quantile(values, 0.99), max: values.length ? quantile(values, 1) : NaN };
}

export function rounded(value) {
  if (typeof value === 'number') return Number.isFinite(value) ? Math.round(value * 1000) / 1000 : null;
  if (Array.isArray(value)) return value.map(rounded);
  if (typeof value === 'object' && value !== null) return Object.fromEntries(Object.entries(value).map(([key, one]) => [key, rounded(one)]));
  return value;
}

/** Rows of equal shape, printed as a table. */
export function table(title, rows) {
  if (rows.length === 0) return;
  const names = Object.keys(rows[0]);
  const cells = [names, ...rows.map((row) => names.map((name) => String(rounded(row[name]) ?? '-')))];
  const widths = names.map((_, column) => Math.max(...cells.map((line) => line[column].length)));
  console.log(`\n${title}`);
  for (const line of cells) console.log(`  ${line.map((cell, column) => (column === 0 ? cell.padEnd(widths[0]) : cell.padStart(widths[column]))).join('  ')}`);
}

/** "--name value" pairs and "--flag"s over defaults; an unknown one ends the program with the list of options. */
export function arguments_over(defaults) {
  const options = { ...defaults };
  const words = process.argv.slice(2);
  for (let i = 0; i < words.length; ++i) {
    const name = words[i].replace(/^--/, '').replaceAll('-', '_');
    if (!words[i].startsWith('--') || !(name in defaults)) {
      console.error(`unknown '${words[i]}'; there are ${Object.keys(defaults).map((key) => `--${key.replaceAll('_', '-')}`).join(' ')}`);
      process.exit(2);
    }
    const usual = defaults[name];
    if (typeof usual === 'boolean') options[name] = true;
    else options[name] = typeof usual === 'number' ? Number(words[++i]) : words[++i];
  }
  return options;
}

export function report(options, result) {
  if (options.json) writeFileSync(options.json, `${JSON.stringify(rounded(result), null, 2)}\n`);
}
