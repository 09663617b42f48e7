// A seeded generator (splitmix32): the same seed draws the same schedule on every machine.
export class Random {
  constructor(seed) {
    this.state = seed >>> 0;
  }

  /** 0 ≤ result < 1. */
  next() {
    this.state = (this.state + 0x9e3779b9) >>> 0;
    let value = this.state;
    value = Math.imul(value ^ (value >>> 16), 0x21f0aaad);
    value = Math.imul(value ^ (value >>> 15), 0x735a2d97);
    return ((value ^ (value >>> 15)) >>> 0) / 0x100000000;
  }

  /** An integer, both ends included. */
  integer(low, high) {
    return low + Math.floor(this.next() * (high - low + 1));
  }

  /** Between both ends, with equal density of the logarithm: short and long ones are drawn equally often. */
  spread(low, high) {
    return Math.round(low * (high / low) ** this.next());
  }

  chance(ratio) {
    return this.next() < ratio;
  }

  one_of(list) {
    return list[this.integer(0, list.length - 1)];
  }

  shuffled(list) {
    const copy = [...list];
    for (let i = copy.length - 1; i > 0; --i) {
      const j = this.integer(0, i);
      [copy[i], copy[j]] = [copy[j], copy[i]];
    }
    return copy;
  }
}
