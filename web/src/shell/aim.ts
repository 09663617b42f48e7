/** How long rows stay in place after the last pointer movement [ms]; an idle pointer does not hold them. */
export const aiming_ms = 1_000;

/** Keeps moving rows in place while the user points at one of them, so that the intended row is pressed. */
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
    this.move(); // the click event follows
  };
}
