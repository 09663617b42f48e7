// CRC-32C and BLAKE2b-256, written from their definitions (RFC 3720 appendix B, RFC 7693), and XXH3-128 of another library
// than the platform's: the harness must not share these.
import { createXXHash128 } from 'hash-wasm';

const xxh3 = await createXXHash128();

/** XXH3-128 without a seed, 16 bytes, big endian. */
export function xxh3_128(bytes) {
  return Buffer.from(xxh3.init().update(bytes).digest('binary'));
}

const crc_table = new Uint32Array(256).map((_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; ++bit) value = value & 1 ? (value >>> 1) ^ 0x82f63b78 : value >>> 1;
  return value >>> 0;
});

/** Castagnoli's CRC of all bytes. */
export function crc32c(bytes) {
  let crc = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) crc = crc_table[(crc ^ bytes[i]) & 0xff] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

// The fractional parts of the square roots of the first eight primes, as in SHA-512: low and high words alternate.
const initial = new Uint32Array([
  0xf3bcc908, 0x6a09e667, 0x84caa73b, 0xbb67ae85, 0xfe94f82b, 0x3c6ef372, 0x5f1d36f1, 0xa54ff53a,
  0xade682d1, 0x510e527f, 0x2b3e6c1f, 0x9b05688c, 0xfb41bd6b, 0x1f83d9ab, 0x137e2179, 0x5be0cd19,
]);
const sigma = [
  [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
  [14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3],
  [11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4],
  [7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8],
  [9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13],
  [2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9],
  [12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11],
  [13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10],
  [6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5],
  [10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0],
];
const lanes = [[0, 4, 8, 12], [1, 5, 9, 13], [2, 6, 10, 14], [3, 7, 11, 15], [0, 5, 10, 15], [1, 6, 11, 12], [2, 7, 8, 13], [3, 4, 9, 14]];
const block_bytes = 128;
const digest_bytes = 32;
const v = new Uint32Array(32);
const m = new Uint32Array(32);

/** v[a] += v[b] + m[x] and v[d] = (v[d] xor v[a]) rotated to the right by `bits`; indices are of 64-bit words. */
function add_and_rotate(a, b, x, d, bits) {
  let low = v[2 * a] + v[2 * b] + (x < 0 ? 0 : m[2 * x]);
  v[2 * a + 1] += v[2 * b + 1] + (x < 0 ? 0 : m[2 * x + 1]) + Math.floor(low / 0x100000000);
  v[2 * a] = low;
  low = v[2 * d] ^ v[2 * a];
  const high = v[2 * d + 1] ^ v[2 * a + 1];
  if (bits === 63) {
    v[2 * d] = (low << 1) | (high >>> 31);
    v[2 * d + 1] = (high << 1) | (low >>> 31);
  } else {
    v[2 * d] = bits === 32 ? high : (low >>> bits) | (high << (32 - bits));
    v[2 * d + 1] = bits === 32 ? low : (high >>> bits) | (low << (32 - bits));
  }
}

function mix(lane, x, y) {
  const a = lane[0];
  const b = lane[1];
  const c = lane[2];
  const d = lane[3];
  add_and_rotate(a, b, x, d, 32);
  add_and_rotate(c, d, -1, b, 24);
  add_and_rotate(a, b, y, d, 16);
  add_and_rotate(c, d, -1, b, 63);
}

function compress(h, block, counted, last) {
  v.set(h, 0);
  v.set(initial, 16);
  v[24] ^= counted; // less than 4 GiB
  if (last) {
    v[28] = ~v[28];
    v[29] = ~v[29];
  }
  for (let i = 0; i < 32; ++i) m[i] = block.readUInt32LE(4 * i);
  for (let round = 0; round < 12; ++round) {
    const s = sigma[round % 10];
    for (let i = 0; i < 8; ++i) mix(lanes[i], s[2 * i], s[2 * i + 1]);
  }
  for (let i = 0; i < 16; ++i) h[i] ^= v[i] ^ v[i + 16];
}

/** BLAKE2b with 32 bytes of output and no key, of a Buffer. */
export function blake2b256(bytes) {
  const h = new Uint32Array(initial);
  h[0] ^= 0x01010000 ^ digest_bytes;
  let at = 0;
  for (; bytes.length - at > block_bytes; at += block_bytes) compress(h, bytes.subarray(at, at + block_bytes), at + block_bytes, false);
  const tail = Buffer.alloc(block_bytes);
  bytes.copy(tail, 0, at);
  compress(h, tail, bytes.length, true);
  const digest = Buffer.alloc(digest_bytes);
  for (let i = 0; i < digest_bytes / 4; ++i) digest.writeUInt32LE(h[i] >>> 0, 4 * i);
  return digest;
}
