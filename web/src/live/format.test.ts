import { describe, expect, it } from 'vitest';
import { duration, length, manufacturer, mark, percent, serial, share, speed } from './format';

const plain = (text: string) => text.replace(/\u202f/g, ' ');

describe('numbers as people read them', () => {
  it('never hides millimetres', () => {
    expect(plain(length(0.0021))).toBe('2.1 mm');
    expect(plain(length(0.1234))).toBe('123 mm');
    expect(plain(length(1.234))).toBe('1.23 m');
  });

  it('says times in the unit that fits', () => {
    expect(plain(duration(0.4))).toBe('< 1 ms');
    expect(plain(duration(42.4))).toBe('42 ms');
    expect(plain(duration(1290))).toBe('1.2 s');
    expect(plain(duration(185_000))).toBe('3 min 05 s');
  });

  it('never rounds a share up to always', () => {
    expect(plain(share(1))).toBe('100 %');
    expect(plain(share(0.9996))).toBe('99.9 %');
    expect(plain(share(0.5))).toBe('50.0 %');
  });

  it('says nothing rather than zero for an unknown charge', () => {
    expect(percent(null)).toBe('–');
    expect(plain(percent(86.6))).toBe('87 %');
  });

  it('keeps two decimals of speed', () => {
    expect(plain(speed(0.3))).toBe('0.30 m/s');
  });

  it('marks a vehicle by its number, a foreign one by its serial', () => {
    expect(mark('CoSiVA/AIV7', 7)).toBe('7');
    expect(mark('RobotCompany/001', 0)).toBe('001');
    expect(serial('RobotCompany/001')).toBe('001');
    expect(manufacturer('RobotCompany/001')).toBe('RobotCompany');
    expect(manufacturer('odd')).toBe('');
  });
});
