// What a test opened is closed in reverse order, as a stack: node:test runs its `after` hooks first come, first served,
// and would remove a folder before it ends the process that lives in it.
const stacks = new WeakMap();

export function finally_do(t, action) {
  let stack = stacks.get(t);
  if (!stack) {
    stack = [];
    stacks.set(t, stack);
    t.after(async () => {
      const errors = [];
      for (const each of stack.reverse()) {
        try {
          await each();
        } catch (error) {
          errors.push(error);
        }
      }
      if (errors.length > 0) throw errors[0];
    });
  }
  stack.push(action);
}
