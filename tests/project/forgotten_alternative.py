#!/usr/bin/env python3
"""An alternative of a scene that is added in its header alone does not compile where it is forgotten.

forgotten_alternative.py SOURCE INCLUDE GENERATED CXX [LIST...]: adds a dummy to each list, in a copy of its one header,
and compiles the sources that have to know it. Each has to refuse it.
"""

import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

# The header, the list in it, a dummy that has all that a header asks of its kind, and the sources that visit the list.
DUMMY_FIELDS = """struct Dummy {
    static constexpr const char* alternative = "dummy";
    bool operator==(const Dummy&) const = default;
    static void fields(auto&, auto&&) {}
};
"""
DUMMY_READOUT = """struct Dummy {
    static constexpr const char* table = "dummies";
    TimePoint time{};
    PatchIndex patch{};
    void columns(auto&& f) const {
        f("time", time);
        f("patch", patch);
    }
};
"""
DUMMY_NEURON = """struct Dummy {
    bool operator==(const Dummy&) const = default;
};
"""
LISTS = {
    "neuron": ("neurons/parameters.hpp", "using NeuronModel = std::variant<", DUMMY_NEURON,
               ["neurons/models.cpp", "neurons/rate.cpp", "decoders/interval_drive.cpp"]),
    "encoder": ("scene/encoder.hpp", "using Encoder = std::variant<", DUMMY_FIELDS,
                ["scene/encoder.cpp"]),
    "source": ("scene/source.hpp", "using Source =\n    std::variant<", DUMMY_FIELDS,
               ["scene/source.cpp", "nodes/coprocessor_end.cpp"]),
    "transport": ("scene/link.hpp", "using Transport = std::variant<", DUMMY_FIELDS,
                  ["scene/link.cpp", "nodes/hello.cpp"]),
    "decoder": ("scene/decoder.hpp", "    std::variant<SlidingWindow", DUMMY_FIELDS, ["scene/decoder.cpp"]),
    "output": ("scene/output.hpp", "using Output = std::variant<", DUMMY_FIELDS,
               ["scene/output.cpp", "nodes/outputs.cpp"]),
    "distribution": ("scene/afferents.hpp", "using Distribution = std::variant<", DUMMY_FIELDS,
                     ["scene/afferents.cpp"]),
    "outline": ("scene/afferents.hpp", "    std::variant<Rectangle", DUMMY_FIELDS, ["scene/afferents.cpp"]),
    # A read-out needs nothing but its columns.
    "read-out": ("decoders/readout.hpp", "using PatchReadout = std::variant<", DUMMY_READOUT, []),
}
GENERIC = {"read-out": ["studies/kept_results.cpp", "apps/readout_tables.cpp"]}


def with_dummy(text: str, beginning: str, dummy: str) -> str:
    """The header with the dummy before the list, or before the struct that has the list as a member, and in it."""
    at = text.index(beginning)
    end = text.index(">", at)
    name = "Dummy"
    text = text[:end] + ", " + name + text[end:]
    before = at if beginning.startswith("using") else text.rindex("\nstruct ", 0, at) + 1
    comment = re.search(r"(?:^//[^\n]*\n)*\Z", text[:before], re.M)
    before = comment.start() if comment else before
    return text[:before] + dummy + "\n" + text[before:]


def compile_together(compiler: list[str], source: pathlib.Path, files: list[str]) -> str:
    """What the compiler says of these sources as one; empty where it accepts them."""
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as together:
        together.writelines(f'#include "{source / file}"\n' for file in files)
        together.flush()
        done = subprocess.run([*compiler, together.name], capture_output=True, text=True)
    return done.stderr if done.returncode else ""


def main() -> int:
    source = pathlib.Path(sys.argv[1]).resolve()
    base = [*shlex.split(sys.argv[4]), "-std=c++20", "-fsyntax-only", "-w", f"-isystem{sys.argv[3]}"]
    include = [f"-I{sys.argv[2]}"]
    wrong = 0
    for name in sys.argv[5:] or LISTS:
        header, beginning, dummy, places = LISTS[name]
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "afferent" / header
            copy.parent.mkdir(parents=True)
            copy.write_text(with_dummy((source / header).read_text(), beginning, dummy))
            overlaid = [*base, f"-I{folder}", *include]
            if places:
                said = compile_together(overlaid, source, places)
                # A refusal names what it refuses.
                missing = [place for place in places if f"{place}:" not in said or "Dummy" not in said]
            else:
                missing = []
            refused = compile_together(overlaid, source, GENERIC.get(name, []))
        if missing or refused:
            wrong += 1
            print(f"{name}: a dummy is accepted by {missing}; refused: {refused}")
        else:
            print(f"{name}: {header}, then " + (", ".join(places) or "nothing else"))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
