// The theme: light, dark or the system's choice, stored in the browser. The style sheet receives the resolved theme.

export type Theme = 'system' | 'light' | 'dark';
const key = 'cosiva.theme';

class ThemeChoice {
  chosen = $state<Theme>('system');
  /** incremented when colours may have changed, so that the canvas reads them again */
  revision = $state(0);
  private system_dark = false;

  choose(theme: Theme): void {
    this.chosen = theme;
    try {
      localStorage.setItem(key, theme);
    } catch {
      // Private windows may refuse storage; the choice then lasts as long as the page.
    }
    this.show();
  }

  next(): void {
    const order: Theme[] = ['system', 'light', 'dark'];
    this.choose(order[(order.indexOf(this.chosen) + 1) % order.length]!);
  }

  system(dark: boolean): void {
    this.system_dark = dark;
    this.show();
  }

  private show(): void {
    document.documentElement.dataset['theme'] = this.chosen === 'dark' || (this.chosen === 'system' && this.system_dark) ? 'dark' : 'light';
    this.revision++;
  }
}

export const theme = new ThemeChoice();

export function restore_theme(): void {
  let stored: string | null = null;
  try {
    stored = localStorage.getItem(key);
  } catch {
    // as above
  }
  const system = matchMedia('(prefers-color-scheme: dark)');
  theme.system(system.matches);
  theme.choose(stored === 'light' || stored === 'dark' ? stored : 'system');
  system.addEventListener('change', (event) => theme.system(event.matches));
}
