#!/usr/bin/env python3
"""The planner beside pibt2 (Kei18/pibt2, MIT) on the same maps with the same starts and tasks, in one run.

    bench/planner_vs_pibt2.py FOLDER [--planner build/release/bench/planner] [--seeds 3] [--solver PIBT] [--json]

FOLDER is a checkout of pibt2 with its maps in FOLDER/maps. Its program is compiled in a temporary folder. pibt2 draws starts and
tasks from its seed; the planner gets them from the result file. Steps are those until the last task is finished, the service
time is the mean of finish − appearance, both as pibt2 counts them; ratios are pibt2's over the planner's, above 1 where the
planner is better. Where pibt2 finishes not all tasks (a vehicle starves in a dead end), its result names only those that it has
finished, so that a comparison would be of different tasks: such a run is printed and left out.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
STEPS_MAX = 3000

# Name, map, vehicles, tasks, new tasks in each step, whether the map's file .pd has the squares for pick-up and delivery.
CASES = (
    ("warehouse, 1 task a step", "warehouse.map", 50, 500, 1, True),
    ("warehouse, 10 tasks a step", "warehouse.map", 50, 500, 10, True),
    ("random, all tasks at once", "random-32-32-20.map", 100, 1000, 1000, False),
)


def build(folder, into):
    program = into / "mapd"
    sources = [*sorted(folder.glob("src/*.cpp")), *sorted(folder.glob("graph/src/*.cpp")), folder / "mapd.cpp"]
    subprocess.run(
        ["g++", "-O3", "-march=native", "-std=c++17", "-w", "-include", "cstring", f'-D_MAPDIR_="{folder}/maps/"',
         f"-I{folder}/include", f"-I{folder}/graph/include", *map(str, sources), "-o", str(program)],
        check=True)
    return program


def run_pibt2(program, solver, case, seed, into):
    """The result file's content by key, and its path."""
    _, map_name, vehicles, tasks, per_step, with_squares = case
    instance = into / "instance.txt"
    instance.write_text(
        f"map_file={map_name}\nagents={vehicles}\nseed={seed}\nmax_timestep={STEPS_MAX}\nmax_comp_time=600000\n"
        f"task_frequency={per_step}\ntask_num={tasks}\nspecify_pickup_deliv_locs={int(with_squares)}\n")
    result = into / "result.txt"
    result.unlink(missing_ok=True)
    # Never with -v, which prints thousands of lines.
    subprocess.run([str(program), "-i", str(instance), "-s", solver, "-o", str(result)], check=True,
                   stdout=subprocess.DEVNULL)
    pairs = (line.split("=", 1) for line in result.read_text().splitlines()[:20] if "=" in line)
    return {key: value for key, value in pairs if len(value) < 100}, result


def run_planner(program, folder, case, tasks_file):
    _, map_name, _, _, _, with_squares = case
    command = [program, "deliveries", "--map", str(folder / "maps" / map_name), "--tasks", str(tasks_file), "--json"]
    if with_squares:
        command += ["--pick-ups", str(folder / "maps" / f"{map_name}.pd")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode not in (0, 1):
        sys.exit(run.stderr)
    return json.loads(run.stdout)


def compare(case, seed, args, pibt2, into):
    theirs, result = run_pibt2(pibt2, args.solver, case, seed, into)
    if theirs.get("solved") != "1":
        return {"case": case[0], "seed": seed, "solved": False}
    ours = run_planner(args.planner, args.folder, case, result)
    steps, service = int(theirs["makespan"]), float(theirs["service_time"])
    return {
        "case": case[0], "seed": seed, "solved": ours["delivered"] == ours["loads"],
        "steps": ours["steps"], "steps_pibt2": steps, "ratio_steps": steps / ours["steps"],
        "service": ours["service"], "service_pibt2": service, "ratio_service": service / ours["service"],
        "step_ms_mean": ours["step_ms_mean"], "step_ms_mean_pibt2": float(theirs["comp_time"]) / max(1, steps),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=lambda name: pathlib.Path(name).resolve(), help="a checkout of pibt2")
    parser.add_argument("--planner", default=str(ROOT / "build/release/bench/planner"))
    parser.add_argument("--seeds", type=int, default=3, help="instances of each case")
    parser.add_argument("--solver", default="PIBT", choices=["PIBT", "TP"])
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        into = pathlib.Path(name)
        pibt2 = build(args.folder, into)
        for case in CASES:
            rows += [compare(case, seed, args, pibt2, into) for seed in range(args.seeds)]
    if args.json:
        print(json.dumps(rows, indent=1))
        return
    for row in rows:
        if "steps" not in row:
            print(f"{row['case']}, seed {row['seed']}: {args.solver} does not finish")
            continue
        print(f"{row['case']}, seed {row['seed']}: {row['steps']} steps ({args.solver} {row['steps_pibt2']}, ratio "
              f"{row['ratio_steps']:.3f}), service {row['service']:.1f} ({row['service_pibt2']:.1f}, "
              f"{row['ratio_service']:.3f}), {row['step_ms_mean']:.1f} ms a step ({row['step_ms_mean_pibt2']:.1f})")
    for case in CASES:
        ratios = [row["ratio_steps"] for row in rows if row["case"] == case[0] and "steps" in row]
        if ratios:
            print(f"{case[0]}: median ratio of steps {statistics.median(ratios):.3f} over {len(ratios)} instances")
    if not all(row["solved"] for row in rows if "steps" in row):
        sys.exit("the planner has not finished all tasks")


if __name__ == "__main__":
    main()
