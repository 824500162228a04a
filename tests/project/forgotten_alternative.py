#!/usr/bin/env python3
"""An alternative of a scene that is added in its header alone does not compile where it is forgotten.

forgotten_alternative.py SOURCE INCLUDE GENERATED CXX: adds a dummy to each list, in copies of their headers, and compiles
the sources that have to know them. Each source has to refuse its dummy.
"""

import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

# A dummy has all that a header asks of its kind.
DUMMY_FIELDS = """struct {name} {{
    static constexpr const char* alternative = "dummy";
    bool operator==(const {name}&) const = default;
    static void fields(auto&, auto&&) {{}}
}};
"""
DUMMY_NEURON = """struct {name} {{
    bool operator==(const {name}&) const = default;
}};
"""
DUMMY_READOUT = """struct {name} {{
    static constexpr const char* table = "dummies";
    TimePoint time{{}};
    PatchIndex patch{{}};
    void columns(auto&& f) const {{
        f("time", time);
        f("patch", patch);
    }}
}};
"""
# The dummy, the header, the list in it, and the sources that visit the list.
LISTS = {
    "DummyNeuron": ("neurons/parameters.hpp", "using NeuronModel = std::variant<", DUMMY_NEURON,
                    ["neurons/models.cpp", "neurons/rate.cpp", "decoders/interval_drive.cpp"]),
    "DummyEncoder": ("scene/encoder.hpp", "using Encoder = std::variant<", DUMMY_FIELDS, ["scene/encoder.cpp"]),
    "DummySource": ("scene/source.hpp", "using Source =\n    std::variant<", DUMMY_FIELDS,
                    ["scene/source.cpp", "nodes/coprocessor_end.cpp"]),
    "DummyTransport": ("scene/link.hpp", "using Transport = std::variant<", DUMMY_FIELDS,
                       ["scene/link.cpp", "nodes/hello.cpp"]),
    "DummyDecoder": ("scene/decoder.hpp", "    std::variant<SlidingWindow", DUMMY_FIELDS, ["scene/decoder.cpp"]),
    "DummyOutput": ("scene/output.hpp", "using Output = std::variant<", DUMMY_FIELDS,
                    ["scene/output.cpp", "nodes/outputs.cpp"]),
    "DummyDistribution": ("scene/afferents.hpp", "using Distribution = std::variant<", DUMMY_FIELDS,
                          ["scene/afferents.cpp"]),
    "DummyOutline": ("scene/afferents.hpp", "    std::variant<Rectangle", DUMMY_FIELDS, ["scene/afferents.cpp"]),
}
# A read-out needs nothing but its columns: these sources take it as it is.
READOUT = ("decoders/readout.hpp", "using PatchReadout = std::variant<", DUMMY_READOUT,
           ["studies/kept_results.cpp", "apps/readout_tables.cpp"])


def with_dummy(text: str, name: str, beginning: str, dummy: str) -> str:
    """The header with the dummy before the list, or before the struct that has the list as a member, and in it."""
    at = text.index(beginning)
    end = text.index(">", at)
    text = text[:end] + ", " + name + text[end:]
    before = at if beginning.startswith("using") else text.rindex("\nstruct ", 0, at) + 1
    comment = re.search(r"(?:^//[^\n]*\n)*\Z", text[:before], re.M)
    before = comment.start() if comment else before
    return text[:before] + dummy.format(name=name) + "\n" + text[before:]


def errors(compiler: list[str], source: pathlib.Path, files: list[str]) -> str:
    """The compiler's errors in these sources as one unit; empty where it accepts them."""
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as together:
        together.writelines(f'#include "{source / file}"\n' for file in files)
        together.flush()
        done = subprocess.run([*compiler, together.name], capture_output=True, text=True)
    return done.stderr if done.returncode else ""


def refuses(said: str, file: str, name: str) -> bool:
    """Whether one of the errors was met in the file, or in what it instantiates, and names the dummy."""
    # An error begins with the includes or instantiations that lead to it.
    each = re.split(r"\n(?=In file included from|\S+: In |\S+: At )", said)
    return any(f"{file}:" in error and name in error for error in each)


def main() -> int:
    source = pathlib.Path(sys.argv[1]).resolve()
    base = [*shlex.split(sys.argv[4]), "-std=c++20", "-fsyntax-only", "-w", f"-isystem{sys.argv[3]}"]
    include = f"-I{sys.argv[2]}"
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, (header, beginning, dummy, _) in LISTS.items():
            copy = pathlib.Path(folder) / "afferent" / header
            copy.parent.mkdir(parents=True, exist_ok=True)
            text = (copy if copy.exists() else source / header).read_text()
            copy.write_text(with_dummy(text, name, beginning, dummy))
        # Names in anonymous namespaces are told apart within a folder.
        places = [(place, name) for name, known in LISTS.items() for place in known[3]]
        for part in sorted({place.split("/")[0] for place, _ in places}):
            files = sorted({place for place, _ in places if place.startswith(part + "/")})
            said = errors([*base, f"-I{folder}", include], source, files)
            for place, name in places:
                if place in files and not refuses(said, place, name):
                    wrong += 1
                    print(f"{name} is accepted by {place}, where there was said:\n{said}")
    header, beginning, dummy, places = READOUT
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "afferent" / header
        copy.parent.mkdir(parents=True)
        copy.write_text(with_dummy((source / header).read_text(), "DummyReadout", beginning, dummy))
        said = errors([*base, f"-I{folder}", include], source, places)
        if said:
            wrong += 1
            print(f"DummyReadout is refused:\n{said}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
