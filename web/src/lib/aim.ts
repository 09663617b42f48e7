/** How long rows wait for the press after the pointer's last move; a pointer left lying there stops nothing. */
export const aiming_ms = 1_000;

/** Rows that move while somebody points at them cannot be pressed: they hold still as long as this says so. */
export class Aim {
  private pressed = false;
  private timer = 0;

  constructor(private readonly hold: (held: boolean) => void) {}

  readonly move = (): void => {
    this.hold(true);
    clearTimeout(this.timer);
    if (!this.pressed) this.timer = window.setTimeout(() => this.hold(false), aiming_ms);
  };
  readonly press = (): void => {
    this.pressed = true;
    this.move();
    addEventListener('pointerup', this.release);
    addEventListener('pointercancel', this.release);
  };
  readonly leave = (): void => {
    if (this.pressed) return;
    clearTimeout(this.timer);
    this.hold(false);
  };
  private readonly release = (): void => {
    removeEventListener('pointerup', this.release);
    removeEventListener('pointercancel', this.release);
    this.pressed = false;
    this.move(); // the click comes after this
  };
}
