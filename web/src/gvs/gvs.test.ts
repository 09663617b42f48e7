import { describe, expect, it } from 'vitest';
import { degrees_of, millimetres_of, label_position, path_of, image_of, image_text, rgba_of, type Detection } from './gvs';

const detection: Detection = { vehicle: 'CoSiVA/AIV1', tag: 1, x: 0.125, y: -0.5, heading: 0, outline: [[10, 20], [14, 20], [14, 30], [10, 30]], nose: [[12, 25], [16, 25]] };
const comment = { timestamp: '2026-01-01T00:00:00.000Z', detections: [detection] };

function file(header: string, pixels: number[]): ArrayBuffer {
  const text = new TextEncoder().encode(header);
  const bytes = new Uint8Array(text.length + pixels.length);
  bytes.set(text);
  bytes.set(pixels, text.length);
  return bytes.buffer;
}

describe('the preview of the camera', () => {
  it('is decoded together with its comment', () => {
    const image = image_of(file(`P5\n# ${JSON.stringify(comment)}\n3 2\n255\n`, [0, 1, 2, 10, 20, 255]));
    expect(image).toMatchObject({ width: 3, height: 2, ...comment });
    expect([...image!.grey]).toEqual([0, 1, 2, 10, 20, 255]);
    expect([...rgba_of(image!).slice(12)]).toEqual([10, 10, 10, 255, 20, 20, 20, 255, 255, 255, 255, 255]);
  });

  it('is null for another header, an empty comment, or a truncated image', () => {
    const good = `P5\n# ${JSON.stringify(comment)}\n3 2\n255\n`;
    for (const [header, pixels] of [
      [good.replace('P5', 'P6'), 6],
      [good.replace('255', '65535'), 6],
      [good.replace('3 2', '3 x'), 6],
      [good.replace('3 2', '0 2'), 6],
      [good.replace('3 2', '99999 1'), 6],
      ['P5\n3 2\n255\n', 6],
      ['P5\n# {\n3 2\n255\n', 6],
      ['P5\n# {"timestamp":1,"detections":[]}\n3 2\n255\n', 6],
      [good, 5],
      ['', 0],
    ] as const) {
      expect(image_of(file(header, Array(pixels).fill(7))), header).toBeNull();
    }
  });

  it('has a text alternative for screen readers', () => {
    expect(image_text({ width: 1, height: 1, grey: new Uint8Array(1), ...comment })).toBe('Image of the camera: AIV1 at 0.13, -0.50 m');
    expect(image_text({ width: 1, height: 1, grey: new Uint8Array(1), timestamp: '', detections: [] })).toBe('Image of the camera: no AIV detected');
    expect(image_text(null)).toBe('No image of the camera');
  });

  it('has its outlines as paths, with names above them or, at the upper border, below', () => {
    expect(path_of(detection.outline, true)).toBe('M10 20L14 20L14 30L10 30Z');
    expect(path_of([[1, 2]], false)).toBe('');
    expect(label_position({ ...detection, outline: [[10, 40], [20, 60]] }, 100)).toEqual([15, 34]);
    expect(label_position(detection, 100)).toEqual([12, 48]);
    expect(label_position({ ...detection, outline: [] }, 100)).toBeNull();
  });
});

describe('gaps', () => {
  it('are in millimetres and degrees, or a dash', () => {
    expect(millimetres_of(0.00123)).toBe('1.2\u202fmm');
    expect(degrees_of(Math.PI / 180)).toBe('1.0°');
    expect([millimetres_of(null), degrees_of(null)]).toEqual(['–', '–']);
  });
});
