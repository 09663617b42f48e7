// What a test's context is to e2e/lib, for a program that is no test: it ends, at its end, what was opened.
export class Scope {
  constructor() {
    this.actions = [];
  }

  after(action) {
    this.actions.push(action);
  }

  async end() {
    for (const action of this.actions.reverse()) await action();
  }
}
