#!/usr/bin/env python3
"""What does Python cost? Whole runs beside the program's, and frames of nine neurons beside a program that embeds them.

    PYTHONPATH=build/release/python bench/python_cost.py build/release [--rounds 9]

Python and C++ take turns. A run's time is from its opened source to its last event and estimate, as the program's summary
has it. CPU is what the program's process and the whole call take of the processors, with checks, plan and arrays: it says the
same where other work is beside.
"""
import argparse
import json
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time

import numpy as np

import afferent

PROJECT = pathlib.Path(__file__).resolve().parents[1]
FRAMES = 4000
FRAME_NS = 5_000_000


def spread(values, digits=1):
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def cpu_s(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def program_run_ms(build, scene, folder):
    file = folder / "scene.txtpb"
    file.write_text(scene.text())
    began = cpu_s(resource.RUSAGE_CHILDREN)
    done = subprocess.run([build / "apps/afferent", "run", file, "--json"], check=True, capture_output=True, text=True)
    summary = json.loads(done.stdout)
    return summary["run_time_s"] * 1e3, (cpu_s(resource.RUSAGE_CHILDREN) - began) * 1e3, summary["events"]


def runs(build, rounds, folder):
    print("a run (ms)                the program                     Python  ratio          CPU, its process"
          "       CPU, Python's call  ratio")
    for name, duration_s in (("grasp", 100), ("fingertip", 5), ("hand_17k", 2)):
        scene = afferent.Scene.from_file(PROJECT / f"examples/{name}.txtpb").with_settings({"duration_s": duration_s})
        ours, theirs, processes, calls = [], [], [], []
        for _ in range(rounds):
            program_ms, process_cpu_ms, events = program_run_ms(build, scene, folder)
            theirs.append(program_ms)
            processes.append(process_cpu_ms)
            began = cpu_s(resource.RUSAGE_SELF)
            summary = afferent.run(scene).summary
            calls.append((cpu_s(resource.RUSAGE_SELF) - began) * 1e3)
            assert summary["events"] == events, "Python and the program give the same events"
            ours.append(summary["run_time_s"] * 1e3)
        ratio, cpu_ratio = (statistics.median(one / other for one, other in zip(*both))
                            for both in ((ours, theirs), (calls, processes)))
        print(f"{name:<10} {spread(theirs):>26} {spread(ours):>26} {ratio:6.3f} {spread(processes):>25} {spread(calls):>24} "
              f"{cpu_ratio:6.3f}")


def python_ns_per_frame(coprocessor, push):
    forces_n = np.full(9, 0.5)
    coprocessor.reset()
    coprocessor.push(0, forces_n)
    events = 0
    began = time.perf_counter_ns()
    now = 0
    for _ in range(FRAMES):
        if push:
            coprocessor.push(now, forces_n)
        events += len(coprocessor.advance(now + FRAME_NS - 1))
        now += FRAME_NS
    return (time.perf_counter_ns() - began) / FRAMES, events


def loop_ns():
    """What Python's loop costs by itself."""
    began = time.perf_counter_ns()
    now, events = 0, 0
    nothing = np.empty(0)
    for _ in range(FRAMES):
        events += len(nothing)
        now += FRAME_NS
    return (time.perf_counter_ns() - began) / FRAMES


def frames(build, rounds):
    scene = PROJECT / "examples/grasp.txtpb"
    coprocessor = afferent.Coprocessor(afferent.Scene.from_file(scene))
    figures = {(language, push): [] for language in ("C++", "Python") for push in (True, False)}
    loops, events, expected = [], 0, 0
    for _ in range(rounds):
        done = subprocess.run([build / "bench/afferent_frame_cost", scene, str(FRAMES), "1"], check=True,
                              capture_output=True, text=True).stdout.split()
        expected += int(done[2])
        for push, ns in zip((True, False), done):
            figures["C++", push].append(float(ns))
            ours, fired = python_ns_per_frame(coprocessor, push)
            figures["Python", push].append(ours)
            events += fired
        loops.append(loop_ns())
    assert events == expected, "Python and C++ give the same events"
    print("\na 5 ms frame of nine neurons        C++ (ns)                  Python (ns)            Python's loop (ns)")
    for push, what in ((False, "advance"), (True, "push and advance")):
        ours, theirs = figures["Python", push], figures["C++", push]
        print(f"{what:<18} {spread(theirs, 0):>26} {spread(ours, 0):>26} {spread(loops, 0):>20}")
        extra = statistics.median(one - other for one, other in zip(ours, theirs))
        print(f"{'':<18} Python takes {extra / 1e3:.2f} µs more")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path, help="the build tree, as build/release")
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        runs(options.build, options.rounds, pathlib.Path(scratch))
    frames(options.build, options.rounds)
