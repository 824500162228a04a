#!/usr/bin/python3
"""Question: what does the same population cost in Brian2, and how wrong are its spikes?

Lets `afferent bench scale --export` write a population with its drives and spikes, runs it in Brian2 (C++ standalone, and
with --runtime its NumPy target too) on one thread, and compares run times, and spike times with the true ones.

Truth is a computation of its own for some of the neurons: the exact solution between spikes, its integral by Gauss-Legendre
quadrature to 30 digits, the crossing by a root search (mpmath).

    bench/peers/brian_population.py --afferent build/release/apps/afferent

Exit code 77 where Brian2 is not installed: apt-get install python3-brian
"""
import argparse
import csv
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

warnings.filterwarnings("ignore", category=FutureWarning)  # of packages that Brian2 imports
try:
    import brian2
    import mpmath
    import numpy as np
except ImportError as missing:
    print(f"brian_population.py: {missing}; install it (apt-get install python3-brian) "
          "and use Debian's own Python, /usr/bin/python3", file=sys.stderr)
    sys.exit(77)

METHODS = ("exponential_euler", "rk4")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--afferent", required=True, help="the program afferent, with afferent-bench beside it")
    parser.add_argument("--out", help="folder for peers.csv and the exported population; a temporary one if none")
    parser.add_argument("--elements", type=int, default=10000)
    parser.add_argument("--step-ms", type=float, default=0.1)
    parser.add_argument("--judged", type=int, default=8, help="neurons whose true spikes are computed")
    parser.add_argument("--runtime", action="store_true", help="Brian2's NumPy target too, which is slow")
    parser.add_argument("--quick", action="store_true", help="200 elements, 0.2 s, one method")
    parser.add_argument("--json", action="store_true", help="print the results as JSON")
    return parser.parse_args()


class Population:
    """What afferent exported (bench/scale_export.hpp)."""

    def __init__(self, folder):
        with open(folder / "parameters.csv", encoding="utf-8") as file:
            row = next(csv.DictReader(file))
        self.__dict__.update({name: float(value) for name, value in row.items()})
        self.elements, self.frames = int(self.elements), int(self.frames)
        self.v_th_mv, self.v_mv, self.drives_mv = (
            np.load(folder / f"{name}.npy") for name in ("v_th_mv", "v_mv", "drives_mv"))
        times, addresses = np.load(folder / "spike_time_ns.npy"), np.load(folder / "spike_address.npy")
        self.trains = by_neuron(times.astype(float) * 1e-9, addresses, self.elements)

    @property
    def duration_s(self):
        return self.frames * self.frame_ms * 1e-3


def by_neuron(times_s, addresses, elements):
    order = np.lexsort((times_s, addresses))
    ends = np.searchsorted(addresses[order], np.arange(1, elements))
    return np.split(times_s[order], ends)


def true_train(population, i):
    """Exact spike times of one neuron, in s.

    With w = v - E_k, time in units of tau_m, g(s) = g0 exp(-s/a), under a held drive with b = v_r + RI - E_k:
    w(s) = exp(-G(s)) (w0 + b * integral of exp(G(u)) du from 0 to s), G(s) = s + a (g0 - g(s)).
    """
    mp = mpmath.mp
    mp.dps = 30
    tau_ms = mpmath.mpf(population.tau_m_ms)
    a = population.tau_g_ms / tau_ms
    reset = mpmath.mpf(population.v_r_mv) - population.e_k_mv
    threshold = mpmath.mpf(float(population.v_th_mv[i])) - population.e_k_mv
    w, g = mpmath.mpf(float(population.v_mv[i])) - population.e_k_mv, mpmath.mpf(0)
    frame = population.frame_ms / tau_ms
    nodes = quadrature()

    def after(s, w0, g0, b):
        grown = lambda u: u - a * g0 * mpmath.expm1(-u / a)
        # At 20 nodes the integrand, smooth over half a membrane time, is integrated to better than 1e-25.
        half = s / 2
        integral = half * sum(weight * mpmath.exp(grown(half * (1 + x)) - grown(s)) for x, weight in nodes)
        return w0 * mpmath.exp(-grown(s)) + b * integral

    spikes = []
    for row in range(population.frames):
        b = reset + mpmath.mpf(float(population.drives_mv[row, i]))
        left, begin = frame, row * frame
        # A held drive takes v over the threshold at most once: it has crossed if it is above at the end.
        while (end := after(left, w, g, b)) >= threshold:
            s = crossing(lambda s, w=w, g=g, b=b: after(s, w, g, b), lambda v, s, g=g, b=b:
                         b - (1 + g * mpmath.exp(-s / a)) * v, threshold, left)
            begin, left = begin + s, left - s
            spikes.append(begin * tau_ms / 1000)
            g, w = g * mpmath.exp(-s / a) + population.delta_g, reset
        w, g = end, g * mpmath.exp(-left / a)
    return spikes


def crossing(value, slope, threshold, longest):
    """Newton's method within a bracket."""
    low, high, s = mpmath.mpf(0), longest, longest
    for _ in range(100):
        v = value(s)
        low, high = (s, high) if v < threshold else (low, s)
        step = (threshold - v) / slope(v, s)
        if abs(step) < mpmath.mpf(10) ** -22:
            return s + step
        s = s + step if low <= s + step <= high else (low + high) / 2
    raise RuntimeError("the crossing was not found")


def quadrature(count=20):
    """Nodes and weights on [-1, 1]."""
    found = []
    for guess in np.polynomial.legendre.leggauss(count)[0]:
        x = mpmath.findroot(lambda x: mpmath.legendre(count, x), mpmath.mpf(float(guess)))
        slope = count * (x * mpmath.legendre(count, x) - mpmath.legendre(count - 1, x)) / (x * x - 1)
        found.append((x, 2 / ((1 - x * x) * slope * slope)))
    return found


def brian_population(population, method):
    """The same neurons, equations and drives; every drive is held for its frame."""
    b2 = brian2
    drives = b2.TimedArray(population.drives_mv * b2.mV, dt=population.frame_ms * b2.ms)
    group = b2.NeuronGroup(
        population.elements,
        """dv/dt = (v_r - v + drives(t, i) - g * (v - e_k)) / tau_m : volt
           dg/dt = -g / tau_g : 1
           v_th : volt (constant)""",
        threshold="v >= v_th", reset="v = v_r; g += delta_g", method=method,
        namespace={"v_r": population.v_r_mv * b2.mV, "e_k": population.e_k_mv * b2.mV,
                   "tau_m": population.tau_m_ms * b2.ms, "tau_g": population.tau_g_ms * b2.ms,
                   "delta_g": population.delta_g, "drives": drives})
    group.v = population.v_mv * b2.mV
    group.v_th = population.v_th_mv * b2.mV
    monitor = b2.SpikeMonitor(group)
    return b2.Network(group, monitor), monitor


def run_standalone(population, method, step_ms):
    """Run time, build time and spike trains. The run time is that of Brian2's own loop over the steps, or the processor time
    of its process, whichever is less: on a busy machine the loop is made to wait. The median of five."""
    b2 = brian2
    folder = tempfile.mkdtemp(prefix="brian-")
    try:
        b2.set_device("cpp_standalone", build_on_run=False)
        b2.prefs.devices.cpp_standalone.openmp_threads = 0
        b2.defaultclock.dt = step_ms * b2.ms
        network, monitor = brian_population(population, method)
        network.run(population.duration_s * b2.second)
        begin = time.perf_counter()
        b2.device.build(directory=folder, compile=True, run=False, with_output=False)
        build_s = time.perf_counter() - begin
        runs_s = []
        for _ in range(5):
            before_s = children_s()
            b2.device.run(folder, with_output=False, run_args=[])
            runs_s.append(min(b2.device._last_run_time, children_s() - before_s))
        return sorted(runs_s)[2], build_s, trains_of(population, monitor)
    finally:
        b2.device.reinit()
        b2.set_device("runtime")
        shutil.rmtree(folder, ignore_errors=True)


def children_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_runtime(population, method, step_ms):
    b2 = brian2
    b2.prefs.codegen.target = "numpy"
    b2.defaultclock.dt = step_ms * b2.ms
    network, monitor = brian_population(population, method)
    network.run(0 * b2.ms)
    begin = time.process_time()
    network.run(population.duration_s * b2.second)
    return time.process_time() - begin, 0.0, trains_of(population, monitor)


def trains_of(population, monitor):
    return by_neuron(np.asarray(monitor.t), np.asarray(monitor.i), population.elements)


def errors_s(truth, train):
    """Errors of the spikes that have one true spike within half an interval, and how many true ones have none."""
    truth, train = np.asarray(truth, dtype=np.longdouble), np.asarray(train, dtype=np.longdouble)
    if len(truth) < 2 or len(train) == 0:
        return [], len(truth)
    nearest = train[np.clip(np.searchsorted((train[1:] + train[:-1]) / 2, truth), 0, len(train) - 1)]
    errors = nearest - truth
    near = np.abs(errors) < np.diff(truth).min() / 2
    return list(errors[near]), int((~near).sum())


def judge(truth, trains):
    errors, missed = [], 0
    for i, true in truth.items():
        found, without = errors_s([float(t) for t in true], trains[i])
        errors += found
        missed += without
    errors = np.asarray(errors, dtype=float)
    return {"spikes": int(sum(map(len, trains))), "judged_errors": len(errors), "missed": missed,
            "rms_us": 1e6 * float(np.sqrt(np.mean(errors ** 2))),
            # Spikes on a grid of steps are recorded where the step begins: half a step is taken for granted.
            "rms_us_less_bias": 1e6 * float(np.std(errors))}


def main():
    options = arguments()
    elements = 200 if options.quick else options.elements
    out = Path(options.out or tempfile.mkdtemp(prefix="afferent-peers-"))
    out.mkdir(parents=True, exist_ok=True)
    command = [options.afferent, "bench", "scale", "--export", str(out), "--elements", str(elements), "--json"]
    if options.quick:
        command.append("--quick")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    population = Population(out)
    judged = np.linspace(0, elements - 1, min(options.judged, elements)).astype(int)
    truth = {int(i): true_train(population, int(i)) for i in judged}

    rows = []
    for form in ("dense", "sparse"):
        rows.append({"simulator": "afferent", "method": form, "run_s": getattr(population, f"{form}_s"), "build_s": 0.0,
                     **judge(truth, population.trains)})
    if rows[0]["missed"] > 0 or rows[0]["rms_us"] > 1e-3:
        sys.exit(f"Afferent's spikes are wrong: {rows[0]}")
    for method in METHODS[:1] if options.quick else METHODS:
        run_s, build_s, trains = run_standalone(population, method, options.step_ms)
        rows.append({"simulator": "brian2 C++ standalone", "method": method, "run_s": run_s, "build_s": build_s,
                     **judge(truth, trains)})
    if options.runtime:
        run_s, build_s, trains = run_runtime(population, METHODS[0], options.step_ms)
        rows.append({"simulator": "brian2 NumPy", "method": METHODS[0], "run_s": run_s, "build_s": build_s,
                     **judge(truth, trains)})
    ours = rows[0]
    for row in rows:
        row["times_afferent_run"] = row["run_s"] / ours["run_s"]
        row["times_afferent_error"] = row["rms_us_less_bias"] / ours["rms_us_less_bias"]
    with open(out / "peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    if options.json:
        print(json.dumps({"elements": elements, "duration_s": population.duration_s, "step_ms": options.step_ms,
                          "brian2": brian2.__version__, "peers": rows}, indent=2))
        return
    print(f"{elements} neurons, {population.duration_s:g} s, {int(population.events)} spikes; Brian2 {brian2.__version__} "
          f"in steps of {options.step_ms:g} ms; one thread each")
    for row in rows:
        print(f"  {row['simulator']:22} {row['method']:18} run {row['run_s']:8.3f} s (x {row['times_afferent_run']:.3g}), "
              f"build {row['build_s']:5.1f} s; {row['spikes']} spikes, RMS error {row['rms_us']:.3g} us, "
              f"{row['rms_us_less_bias']:.3g} without its mean (x {row['times_afferent_error']:.3g}), "
              f"{row['missed']} of {row['missed'] + row['judged_errors']} without one")


if __name__ == "__main__":
    main()
