// The official VDA 5050 schemas as modules, without what only people read in them: a fifth of the size.
const annotations = new Set(['$schema', 'title', 'description', 'examples', 'unit', 'subtopic']);

function bare(node) {
  if (Array.isArray(node)) return node;
  if (typeof node !== 'object' || node === null) return node;
  const used = Object.entries(node).filter(([key]) => !annotations.has(key));
  return Object.fromEntries(used.map(([key, value]) => [key, key === 'properties' || key === 'definitions' ? named(value) : bare(value)]));
}
/** A property may be called "title" or "description": there the names are data. */
const named = (map) => Object.fromEntries(Object.entries(map).map(([name, schema]) => [name, bare(schema)]));

export function vda_schemas() {
  return {
    name: 'vda-schemas',
    transform(code, id) {
      return id.endsWith('.schema') ? { code: `export default ${JSON.stringify(bare(JSON.parse(code)))}`, map: null } : null;
    },
  };
}
