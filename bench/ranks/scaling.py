#!/usr/bin/env python3
"""How the run of a population scales over ranks: measures it here, and fits a model to what was measured.

    bench/ranks/scaling.py measure --out out/ranks/ranks.csv
    bench/ranks/scaling.py fit out/ranks/ranks.csv [--message-us 2] [--gigabytes-per-s 10]

docs/ranks.md explains the columns, the model and its assumptions. Takes Python 3 and a build with -DAFFERENT_MPI=ON.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile

ELEMENTS_PER_PATCH = 1024
COLUMNS = ["series", "elements", "ranks", "repeat", "windows", "events", "run_time_s", "rank", "rank_afferents",
           "rank_events", "compute_ms", "rest_ms", "wait_ms", "run_ms", "bytes_per_window"]


def scene(elements, force_n, duration_s):
    """Adapting neurons that differ, about 30 Hz each at 0.4 N, on 200 Hz samples; packets are made of the events."""
    patches = "\n".join(f'patch {{ name: "p{i}" }}' for i in range(elements // ELEMENTS_PER_PATCH))
    return f"""duration_s: {duration_s}
every_patch {{
    elements: {ELEMENTS_PER_PATCH}
    sensor {{ rate_hz: 200 }}
    encoder {{ sustained {{ gain_mv_per_n: 25 bias_mv: 14 }} }}
    neuron {{ tau_m_ms: 10 tau_g_ms: 100 delta_g: 0.2 }}
    spread {{ threshold {{ normal {{ sd: 0.02 }} }} phase {{ uniform {{ lowest: 0 }} }} }}
}}
{patches}
source {{ profile {{ point {{ force_n: {force_n * elements} }} }} }}
link {{ unix_socket {{}} }}
record {{ events: false force: false picture: false }}
runtime {{ threads: 1 }}
"""


def run(program, mpirun, ranks, file):
    command = [program, "run", file, "--json"]
    if mpirun:
        command = [mpirun, "-n", str(ranks)] + command
    # More ranks than processors are of use, because processor time is measured, too.
    environment = dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none")
    if os.geteuid() == 0:
        environment.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    return json.loads(done.stdout)


def rows_of(summary, series, elements, ranks, repeat):
    common = {"series": series, "elements": elements, "ranks": ranks, "repeat": repeat,
              "events": summary["events"], "run_time_s": summary["run_time_s"]}
    if "ranks" not in summary:
        return [common]
    return [dict(common, windows=summary["windows"], rank=rank, rank_afferents=summary["rank_afferents"][rank],
                 rank_events=summary["rank_events"][rank], compute_ms=summary["compute_ms_per_window"][rank],
                 rest_ms=summary["rest_ms_per_window"][rank], wait_ms=summary["wait_ms_per_window"][rank],
                 run_ms=summary["run_ms_per_window"][rank],
                 bytes_per_window=summary["gathered_bytes_per_window"]) for rank in range(ranks)]


def measure(options):
    ranks = range(1, options.most_ranks + 1)
    jobs = []
    for repeat in range(options.repeats):
        for k in ranks:
            jobs.append(("strong", options.elements, 0.4, k, repeat))
            jobs.append(("weak", options.elements // 4 * k, 0.4, k, repeat))
        # Fewer events from as many neurons, and many ranks, tell the costs of events and messages apart.
        jobs.append(("quiet", options.elements, 0.1, 2, repeat))
        jobs.append(("many", options.elements // 4, 0.1, 8, repeat))
    events = {}
    os.makedirs(os.path.dirname(os.path.abspath(options.out)), exist_ok=True)
    with open(options.out, "w", newline="") as out, tempfile.TemporaryDirectory() as folder:
        writer = csv.DictWriter(out, COLUMNS)
        writer.writeheader()
        for series, elements, force_n, k, repeat in jobs:
            file = os.path.join(folder, "scene.txtpb")
            with open(file, "w") as text:
                text.write(scene(elements, force_n, options.duration_s))
            # One process is afferent itself; once more as a rank, it tells where its time goes.
            ways = [(options.program, options.mpirun)]
            if k == 1:
                ways = [(options.program, None), (options.program + "-ranks", options.mpirun)]
            for program, mpirun in ways:
                summary = run(program, mpirun, k, file)
                # Any number of ranks gives the same events.
                if events.setdefault((elements, force_n), summary["events"]) != summary["events"]:
                    sys.exit(f"{elements} elements on {k} ranks: {summary['events']} events, not as before")
                writer.writerows(rows_of(summary, series, elements, k, repeat))
                out.flush()
                print(f"{series}: {elements} elements, {k} ranks: {summary['run_time_s']:.3f} s", file=sys.stderr)


def least_squares(rows, targets):
    """Weights >= 0 of the columns, with errors relative to the targets."""
    used = list(range(len(rows[0])))
    while used:
        a = [[sum(r[i] * r[j] / t / t for r, t in zip(rows, targets)) for j in used] +
             [sum(r[i] / t for r, t in zip(rows, targets))] for i in used]
        for i in range(len(used)):
            pivot = max(range(i, len(used)), key=lambda row: abs(a[row][i]))
            a[i], a[pivot] = a[pivot], a[i]
            for j in range(len(used)):
                if j != i and a[i][i] != 0:
                    factor = a[j][i] / a[i][i]
                    a[j] = [x - factor * y for x, y in zip(a[j], a[i])]
        weights = [row[-1] / row[i] if row[i] else 0 for i, row in enumerate(a)]
        if min(weights) >= 0:
            break
        used.pop(weights.index(min(weights)))
    found = dict(zip(used, weights)) if used else {}
    return [found.get(i, 0) for i in range(len(rows[0]))]


class Model:
    """Milliseconds per window; see docs/ranks.md."""

    def __init__(self, rows):
        def column(row, name):
            return float(row[name])

        ranked = [row for row in rows if row["rank"]]

        def working(row):
            return row["rank"] == "0" or int(row["rank_afferents"]) > 0

        busy = [row for row in ranked if int(row["rank_afferents"]) > 0]
        per_window = [(row, column(row, "rank_events") / column(row, "windows")) for row in busy]
        self.neuron, self.spike = least_squares(
            [[column(row, "rank_afferents"), events] for row, events in per_window],
            [column(row, "compute_ms") for row, _ in per_window])
        # What a rank does besides computing: it samples for its neurons and sends their events; rank 0 also has the
        # packets of all events, and messages of all ranks.
        def rest(row, own_events):
            is_first = row["rank"] == "0"
            return [column(row, "rank_afferents"), 0 if is_first else own_events, float(is_first),
                    is_first * column(row, "events") / column(row, "windows"), is_first * (column(row, "ranks") - 1)]

        self.sample, self.sent, self.fixed, self.event, self.message = least_squares(
            [rest(row, column(row, "rank_events") / column(row, "windows")) for row in ranked if working(row)],
            [column(row, "rest_ms") for row in ranked if working(row)])

    def first_ms(self, events, ranks, message_ms, bytes_per_ms):
        """What only rank 0 does."""
        gathered = 8 * events + 16 * (ranks - 1) if ranks > 1 else 0
        return self.fixed + self.event * events + message_ms * (ranks - 1) + gathered / bytes_per_ms

    def window_ms(self, elements, events, ranks, message_ms=None, bytes_per_ms=float("inf")):
        message_ms = self.message if message_ms is None else message_ms
        first = self.first_ms(events, ranks, message_ms, bytes_per_ms)
        rate = events / elements
        own = self.neuron + self.spike * rate + self.sample
        if ranks == 1:
            return first + own * elements
        # Rank 0 takes as many neurons as it has time for: first + own n = (own + sent) (elements - n) / (ranks - 1).
        other = (own + self.sent * rate) / (ranks - 1)
        n = min(max((other * elements - first) / (own + other), 0), elements)
        return max(first + own * n, other * (elements - n))


def best(rows, series, ranks):
    """The shortest run: what other programs on the machine cost is left out as far as it can be."""
    runs = [row for row in rows if row["series"] == series and int(row["ranks"]) == ranks]
    return min((float(row["run_time_s"]), int(row["elements"]), int(row["events"])) for row in runs)


def busiest(rows, series, ranks):
    """The processor time of the rank that takes most of it."""
    runs = {}
    for row in rows:
        if row["series"] == series and int(row["ranks"]) == ranks and row["rank"]:
            busy_s = (float(row["compute_ms"]) + float(row["rest_ms"])) * int(row["windows"]) / 1e3
            runs[row["repeat"]] = max(busy_s, runs.get(row["repeat"], 0))
    return min(runs.values())


def fit(options):
    with open(options.csv, newline="") as file:
        rows = list(csv.DictReader(file))
    model = Model(rows)
    windows = next(int(row["windows"]) for row in rows if row["windows"])
    print("ns per window: %.1f to compute a neuron and %.1f a spike, %.1f to sample an element, %.1f to send an event; on "
          "rank 0 %.0f, %.1f for each event and %.0f for each other rank" %
          tuple(1e6 * value for value in (model.neuron, model.spike, model.sample, model.sent, model.fixed,
                                          model.event, model.message)))
    print("\n| series | elements | ranks | run, s | busiest rank's processor time, s | model, s | speed-up by the clock | "
          "by processor time | model |\n|---|---|---|---|---|---|---|---|---|")
    for series in ("strong", "weak"):
        one_s, one_elements, one_events = best(rows, series, 1)
        for ranks in sorted({int(row["ranks"]) for row in rows if row["series"] == series}):
            run_s, elements, events = best(rows, series, ranks)
            busy_s = busiest(rows, series, ranks)
            told_s = model.window_ms(elements, events / windows, ranks) * windows / 1e3
            told_one_s = model.window_ms(one_elements, one_events / windows, 1) * windows / 1e3
            grown = elements / one_elements
            print(f"| {series} | {elements} | {ranks} | {run_s:.3f} | {busy_s:.3f} | {told_s:.3f} | "
                  f"{one_s / run_s * grown:.2f} | {busiest(rows, series, 1) / busy_s * grown:.2f} | "
                  f"{told_one_s / told_s * grown:.2f} |")
    _, elements, events = best(rows, "strong", 1)
    per_element = events / windows / elements
    message_ms = options.message_us / 1e3
    bytes_per_ms = options.gigabytes_per_s * 1e6
    print(f"\nPredicted, {options.message_us} us a message and {options.gigabytes_per_s} GB/s into rank 0:\n\n"
          "| elements | ranks | ms a window | speed-up | of it for rank 0 alone, ms |\n|---|---|---|---|---|")
    for elements in (1_000_000, 100_000_000):
        for ranks in (1, 10, 100, 1000):
            told = model.window_ms(elements, per_element * elements, ranks, message_ms, bytes_per_ms)
            one = model.window_ms(elements, per_element * elements, 1)
            first = model.first_ms(per_element * elements, ranks, message_ms, bytes_per_ms)
            print(f"| {elements} | {ranks} | {told:.3f} | {one / told:.1f} | {first:.3f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    measuring = commands.add_parser("measure", help="run it over ranks, and write a table")
    measuring.add_argument("--out", required=True, help="the table, CSV")
    measuring.add_argument("--program", default="build/release/apps/afferent")
    measuring.add_argument("--mpirun", default="mpirun")
    measuring.add_argument("--elements", type=int, default=65536)
    measuring.add_argument("--duration-s", type=float, default=2)
    measuring.add_argument("--repeats", type=int, default=5)
    measuring.add_argument("--most-ranks", type=int, default=os.cpu_count())
    measuring.set_defaults(run=measure)
    fitting = commands.add_parser("fit", help="fit the model to a table, and print it as Markdown")
    fitting.add_argument("csv")
    fitting.add_argument("--message-us", type=float, default=2)
    fitting.add_argument("--gigabytes-per-s", type=float, default=10)
    fitting.set_defaults(run=fit)
    options = parser.parse_args()
    options.run(options)


main()
