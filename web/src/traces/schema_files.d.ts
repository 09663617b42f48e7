declare module '*.schema' {
  const schema: import('./schema').JsonObject;
  export default schema;
}
