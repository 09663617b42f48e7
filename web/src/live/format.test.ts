import { describe, expect, it } from 'vitest';
import { duration, length, manufacturer, label, percent, serial, ratio, speed } from './format';

const plain = (text: string) => text.replace(/\u202f/g, ' ');

describe('formatted numbers', () => {
  it('never hide millimetres', () => {
    expect(plain(length(0.0021))).toBe('2.1 mm');
    expect(plain(length(0.1234))).toBe('123 mm');
    expect(plain(length(1.234))).toBe('1.23 m');
  });

  it('show times in a suitable unit', () => {
    expect(plain(duration(0.4))).toBe('< 1 ms');
    expect(plain(duration(42.4))).toBe('42 ms');
    expect(plain(duration(1290))).toBe('1.2 s');
    expect(plain(duration(185_000))).toBe('3 min 05 s');
  });

  it('are never rounded up to 100 %', () => {
    expect(plain(ratio(1))).toBe('100 %');
    expect(plain(ratio(0.9996))).toBe('99.9 %');
    expect(plain(ratio(0.5))).toBe('50.0 %');
  });

  it('are empty rather than zero for an unknown charge', () => {
    expect(percent(null)).toBe('–');
    expect(plain(percent(86.6))).toBe('87 %');
  });

  it('have two decimals for speeds', () => {
    expect(plain(speed(0.3))).toBe('0.30 m/s');
  });

  it('label a vehicle by its number, a third-party vehicle by its serial number', () => {
    expect(label('CoSiVA/AIV7', 7)).toBe('7');
    expect(label('RobotCompany/001', 0)).toBe('001');
    expect(serial('RobotCompany/001')).toBe('001');
    expect(manufacturer('RobotCompany/001')).toBe('RobotCompany');
    expect(manufacturer('odd')).toBe('');
  });
});
