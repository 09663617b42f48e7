// The files of a zone that the user chooses on this machine: the zone file and, optionally, its sidecar file.

export interface ChosenZone {
  file: string;
  text: string;
  sidecar?: string;
}

/** The indices of the zone file and of its sidecar, whose name contains ".zone."; an error message if the choice is ambiguous. */
export function sorted_out(names: readonly string[]): { zone: number; sidecar: number | null } | string {
  const is_sidecar = (name: string) => /\.zone\.[^.]+$/.test(name);
  const own = names.flatMap((name, i) => (is_sidecar(name) ? [] : [i]));
  const sidecars = names.flatMap((name, i) => (is_sidecar(name) ? [i] : []));
  if (own.length === 0) return 'Choose the zone file too; this one is only its sidecar file.';
  if (own.length > 1 || sidecars.length > 1) return 'Choose one zone file and its sidecar file: two files at most.';
  return { zone: own[0]!, sidecar: sidecars[0] ?? null };
}

export async function read_zone(files: readonly File[]): Promise<ChosenZone | string> {
  const which = sorted_out(files.map((file) => file.name));
  if (typeof which === 'string') return which;
  const own = files[which.zone]!;
  try {
    return { file: own.name, text: await own.text(), ...(which.sidecar === null ? {} : { sidecar: await files[which.sidecar]!.text() }) };
  } catch {
    return `${own.name} cannot be read.`;
  }
}
