// Reads a store in a thread of its own: the observation of the broker must not wait for hashes.
import { parentPort, workerData } from 'node:worker_threads';
import { commands_of, is_command, read_store } from './store_reader.mjs';

const cache = new Map();

parentPort.on('message', () => {
  try {
    const { records, count, torn, hash } = read_store(workerData.folder, { keep: is_command, cache });
    parentPort.postMessage({ commands: commands_of(records), count, torn, hash: hash.toString('hex') });
  } catch (error) {
    parentPort.postMessage({ damage: error.message });
  }
});
