// The camera image in the server's format: Netpbm P5 (grey, one byte per pixel) with the detected vehicles in its comment.

/** A detected AIV, in pixels of the image. */
export interface Detection {
  vehicle: string;
  tag: number;
  x: number;
  y: number;
  heading: number;
  outline: readonly (readonly [number, number])[];
  /** a line from the centre ahead */
  nose: readonly (readonly [number, number])[];
}

export interface CameraImage {
  width: number;
  height: number;
  /** rows from top to bottom */
  grey: Uint8Array;
  timestamp: string;
  detections: readonly Detection[];
}

const side_max = 4_096;

/** Parses an image; null if the bytes have another format. */
export function image_of(bytes: ArrayBuffer): CameraImage | null {
  const all = new Uint8Array(bytes);
  // "P5\n# {…}\nwidth height\n255\n"
  let at = 0;
  const line = () => {
    const end = all.indexOf(10, at);
    if (end < 0) return '';
    const text = new TextDecoder().decode(all.subarray(at, end));
    at = end + 1;
    return text;
  };
  if (line() !== 'P5') return null;
  const metadata = metadata_of(line());
  const size = /^(\d+) (\d+)$/.exec(line());
  if (!metadata || !size || line() !== '255') return null;
  const [width, height] = [Number(size[1]), Number(size[2])];
  if (width < 1 || height < 1 || width > side_max || height > side_max || all.length - at < width * height) return null;
  return { width, height, grey: all.subarray(at, at + width * height), ...metadata };
}

function metadata_of(comment: string): Pick<CameraImage, 'timestamp' | 'detections'> | null {
  if (!comment.startsWith('# ')) return null;
  try {
    const metadata = JSON.parse(comment.slice(2)) as Partial<CameraImage>;
    return typeof metadata.timestamp === 'string' && Array.isArray(metadata.detections) ? { timestamp: metadata.timestamp, detections: metadata.detections } : null;
  } catch {
    return null;
  }
}

/** The image in the RGBA format of a canvas. */
export function rgba_of({ width, height, grey }: CameraImage): Uint8ClampedArray<ArrayBuffer> {
  const rgba = new Uint8ClampedArray(4 * width * height);
  const pixels = new Uint32Array(rgba.buffer);
  // Three equal bytes and 255 have the same value in both byte orders.
  const little = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;
  for (let i = 0; i < pixels.length; i++) pixels[i] = little ? 0xff000000 | (grey[i]! * 0x010101) : (grey[i]! * 0x01010100) | 0xff;
  return rgba;
}

export const path_of = (points: Detection['outline'], closed: boolean): string => (points.length < 2 ? '' : `M${points.map(([u, v]) => `${u} ${v}`).join('L')}${closed ? 'Z' : ''}`);

/** The position of the label: above the outline if there is room, otherwise below it. */
export function label_position({ outline }: Detection, height: number): readonly [u: number, v: number] | null {
  if (outline.length === 0) return null;
  const us = outline.map(([u]) => u);
  const vs = outline.map(([, v]) => v);
  const above = Math.min(...vs) - 6;
  return [(Math.min(...us) + Math.max(...us)) / 2, above > 14 ? above : Math.min(height - 4, Math.max(...vs) + 18)];
}

const degrees = 180 / Math.PI;
export const degrees_of = (rad: number | null): string => (rad === null ? '–' : `${(rad * degrees).toFixed(1)}°`);
export const millimetres_of = (m: number | null): string => (m === null ? '–' : `${(1_000 * m).toFixed(1)}\u202fmm`);

/** The text alternative of the image, for screen readers. */
export function image_text(image: CameraImage | null): string {
  if (!image) return 'No image of the camera';
  if (image.detections.length === 0) return 'Image of the camera: no AIV detected';
  const each = image.detections.map((detection) => `${detection.vehicle.slice(detection.vehicle.indexOf('/') + 1)} at ${detection.x.toFixed(2)}, ${detection.y.toFixed(2)} m`);
  return `Image of the camera: ${each.join('; ')}`;
}
