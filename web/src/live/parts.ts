// Parts of the platform, which the supervisor of `cosiva up` starts again when they end or hang.
import type { Part } from './contract';

/** A part that does not stay up: the platform continues without it. */
export function failing_parts(parts: readonly Part[] | undefined): Part[] {
  return (parts ?? []).filter((part) => part.state === 'failing');
}

/** "gvs does not stay up (exit 3); started again 12 times". */
export function failing_words({ name, restarts, last_error }: Part): string {
  return `${name} does not stay up${last_error ? ` (${last_error})` : ''}; started again ${restarts === 1 ? 'once' : `${restarts} times`}`;
}

/** "plant was started again: no response; killed (signal 9)". */
export function restarted_words({ name, restarts, last_error }: Part): string {
  return `${name} was started again${restarts > 1 ? `, ${restarts} times so far` : ''}${last_error ? `: ${last_error}` : ''}`;
}
