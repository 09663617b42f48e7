// A zone's files as somebody chooses them on this machine: the zone's own, and beside it perhaps what it cannot say.

export interface ChosenZone {
  file: string;
  text: string;
  companion?: string;
}

/** Files whose name has ".zone." in it stand beside a zone's own. A sentence where it is not clear which is meant. */
export function sorted_out(names: readonly string[]): { zone: number; companion: number | null } | string {
  const beside = (name: string) => /\.zone\.[^.]+$/.test(name);
  const own = names.flatMap((name, i) => (beside(name) ? [] : [i]));
  const companions = names.flatMap((name, i) => (beside(name) ? [i] : []));
  if (own.length === 0) return 'Choose the zone’s own file too; this one only says what that cannot.';
  if (own.length > 1 || companions.length > 1) return 'Choose one zone, and what stands beside it: two files at most.';
  return { zone: own[0]!, companion: companions[0] ?? null };
}

export async function read_zone(files: readonly File[]): Promise<ChosenZone | string> {
  const which = sorted_out(files.map((file) => file.name));
  if (typeof which === 'string') return which;
  const own = files[which.zone]!;
  try {
    return { file: own.name, text: await own.text(), ...(which.companion === null ? {} : { companion: await files[which.companion]!.text() }) };
  } catch {
    return `${own.name} cannot be read.`;
  }
}
