// The state of the connection with the server, as the page shows it.

/** Whether the page shows the present: `unresponsive` is an open connection without frames, `down` a closed one. */
export type Link =
  | { phase: 'connecting'; since_ms: number }
  | { phase: 'live'; since_ms: number }
  | { phase: 'unresponsive'; since_ms: number }
  | { phase: 'down'; since_ms: number };

export type LinkEvent = { kind: 'opened' | 'frame' | 'closed' | 'tick'; at_ms: number; last_frame_ms: number };

/** A socket may stay open while its server hangs; after this time without a frame the link is unresponsive [ms]. */
export const silence_ms = 1_000;

export function link_after(link: Link, event: LinkEvent): Link {
  switch (event.kind) {
    case 'opened':
      return link.phase === 'live' ? link : { phase: 'connecting', since_ms: link.phase === 'down' ? link.since_ms : event.at_ms };
    case 'frame':
      return link.phase === 'live' ? link : { phase: 'live', since_ms: event.at_ms };
    case 'closed':
      return link.phase === 'down' ? link : { phase: 'down', since_ms: link.phase === 'unresponsive' ? link.since_ms : event.at_ms };
    case 'tick':
      if (link.phase === 'live' && event.at_ms - event.last_frame_ms > silence_ms) return { phase: 'unresponsive', since_ms: event.last_frame_ms };
      return link;
  }
}
