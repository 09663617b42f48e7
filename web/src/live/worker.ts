// The worker thread of the live stream. The page sends the address, then acknowledges each message after processing it.
import { Stream, type StreamEvent, type StreamReply } from './worker_stream';

const scope = self as unknown as { postMessage(message: unknown, transfer?: Transferable[]): void; onmessage: ((event: MessageEvent<StreamReply | { kind: 'open'; url: string } | { kind: 'close' }>) => void) | null };
let stream: Stream | null = null;

function emit(event: StreamEvent): void {
  if (event.kind !== 'positions') return scope.postMessage(event);
  const { buffer, count, sequence, time_ms } = event.frame;
  scope.postMessage({ kind: 'positions', buffer, count, sequence, time_ms }, [buffer]);
}

scope.onmessage = ({ data }) => {
  if (data.kind === 'open') stream = new Stream(data.url, emit);
  else if (data.kind === 'close') stream?.close();
  else stream?.taken(data);
};
