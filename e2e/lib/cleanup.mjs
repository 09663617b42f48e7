// Resources that a test opened are closed in reverse order, as a stack: node:test runs its `after` hooks in the order
// of registration, and would remove a folder before it ends the process that works in it.
const stacks = new WeakMap();
const patience_ms = 60_000;

/** An action that never ends must not keep the others from being executed. */
async function within_patience(action) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`not closed within ${patience_ms / 1000} s: ${action}`)), patience_ms);
  });
  try {
    await Promise.race([action(), late]);
  } finally {
    clearTimeout(timer);
  }
}

export function finally_do(t, action) {
  let stack = stacks.get(t);
  if (!stack) {
    stack = [];
    stacks.set(t, stack);
    t.after(async () => {
      const errors = [];
      for (const each of stack.reverse()) {
        try {
          await within_patience(each);
        } catch (error) {
          errors.push(error);
        }
      }
      if (errors.length > 0) throw errors[0];
    });
  }
  stack.push(action);
}
