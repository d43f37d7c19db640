#!/usr/bin/env python3
"""Mutation fuzz over the verbs of the program: broken files and odd flags, one run of the program each.

    cargo build -p asperity
    python3 fuzz/verbs.py --program target/debug/asperity --count 25000

A run fails if it panics, is ended by a signal, ends with a status other than 0, 1 or 2, takes too long or too much memory
(its allocator then aborts), changes an input, leaves a file that was not asked for, or leaves any file after status 2.
The same seed gives the same inputs. Findings are kept in fuzz/artifacts/verbs; `--only N` runs one input again. Only the
standard library is needed.
"""

import argparse
import io
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
import zlib
from concurrent.futures import ThreadPoolExecutor
from math import cos, pi, sin

N = 16  # points along a side of the maps


def height(x, y):
    return 0.15 * sin(2 * pi * 2 * x / N) + 0.1 * cos(2 * pi * 3 * y / N + 0.3) + 0.02 * sin(x * y)


def all_points():
    return [(x, y, height(x, y)) for y in range(N) for x in range(N)]


def rows(scale=1.0):
    return "".join(" ".join(f"{height(x, y) * scale:.6f}" for x in range(N)) + "\n" for y in range(N))


def npy(kind, pack, values):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': ({N}, {N}), }}"
    head += " " * (-(len(head) + 11) % 64) + "\n"
    data = b"".join(struct.pack(pack, v) for v in values)
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + data


def x3p():
    axis = "<AxisType>{}</AxisType><DataType>D</DataType><Increment>{}</Increment>"
    main = (
        '<?xml version="1.0"?><p:ISO5436_2 xmlns:p="x"><Record1><FeatureType>SUR</FeatureType><Axes><CX>'
        + axis.format("I", "1e-6") + "</CX><CY>" + axis.format("I", "1e-6") + "</CY><CZ>"
        + axis.format("A", "1") + f"</CZ></Axes></Record1><Record3><MatrixDimension><SizeX>{N}</SizeX><SizeY>{N}</SizeY>"
        "<SizeZ>1</SizeZ></MatrixDimension><DataLink><PointDataLink>data.bin</PointDataLink></DataLink></Record3>"
        "</p:ISO5436_2>"
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as z:
        for name, content in (("main.xml", main.encode()),
                              ("data.bin", b"".join(struct.pack("<d", 1e-6 * p[2]) for p in all_points()))):
            z.writestr(zipfile.ZipInfo(name), content)
    return file.getvalue()


def png():
    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
    counts = [[round(1000 * (height(x, y) + 0.5)) for x in range(N)] for y in range(N)]
    raw = b"".join(b"\0" + b"".join(struct.pack(">H", c) for c in row) for row in counts)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", N, N, 16, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))


def di():
    lines = [
        r"\*File list", r"\Version: 0x05120130", r"\*Ciao scan list", r"\@Sens. Zsens: V 50 nm/V", r"\*Ciao image list",
        r"\Data offset: 1000", rf"\Data length: {2 * N * N}", r"\Bytes/pixel: 2", rf"\Samps/line: {N}",
        rf"\Number of lines: {N}", r"\Scan Size: 16 16 ~m", r"\@2:Z scale: V [Sens. Zsens] (0.3 mV/LSB) 6 V",
        r"\*File list end",
    ]
    head = ("\r\n".join(lines) + "\r\n").encode()
    return head.ljust(1000, b"\0") + b"".join(struct.pack("<h", round(3e4 * p[2])) for p in all_points())


def sdf():
    head = f"aISO-1.0\nManufacID = maker\nNumPoints = {N}\nNumProfiles = {N}\nXscale = 1e-6\nYscale = 1e-6\n"
    return (head + "Zscale = 1e-6\nDataType = 5\n*\n" + rows() + "*\n").encode()


def maps():
    """Names and contents of height maps, with the flags they need."""
    heights = [p[2] for p in all_points()]
    xyz = "".join(f"{x} {y} {h:.6f}\n" for x, y, h in all_points())
    gwyddion = f"# Channel: a\n# Width: {N} um\n# Height: {N} um\n# Value units: um\n"
    return {
        "m.txt": (("# heights in nm, pixel size 1 um\n" + rows(1e3)).encode(), ""),
        "plain.txt": (rows().encode(), "--pixel-um 1 --z-unit um"),
        "utf16.txt": (("\ufeff# heights in um\n" + rows()).encode("utf-16-le"), "--pixel-um 1"),
        "m.xyz": (("# x [um] y [um] z [um]\n" + xyz).encode(), ""),
        "plain.xyz": (xyz.encode(), "--xy-unit um --z-unit um"),
        "gwyddion.txt": ((gwyddion + rows()).encode(), ""),
        "m.npy": (npy("<f4", "<f", heights), "--pixel-um 1"),
        "counts.npy": (npy("<i2", "<h", [round(1000 * h) for h in heights]), "--pixel-um 1 --z-um 0.001"),
        "m.x3p": (x3p(), ""),
        "m.png": (png(), "--pixel-um 1 --z-um 0.001"),
        "m.di": (di(), ""),
        "m.sdf": (sdf(), ""),
    }


PLAN = """sigma_deg = [0, 30]
theta_from_deg = -90
theta_to_deg = 90
theta_step_deg = 1
aperture_deg = 2
integration_ms = 1
range = "auto"
run_up_deg = 0.5
calibrate = "once"
geometry = "transmission"
sample = "No 5"
ior = 1.49
rough_side = "source"
wavelength_nm = 550
"""
FOREIGN = "a,b,c,name\n" + "".join(
    f"{s},{t},{0.3 * cos(pi * t / 200):.5f},one\n" for s in (0, 30) for t in range(-80, 81, 10))
PAIRS = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n0,0,-1,0.1,0,0.99498743710662\n0.6,0,0.8,-0.6,0,0.8\n"


class Seeds:
    """Small valid files; those that only the program can write are made by it."""

    def __init__(self, program, folder):
        self.files, self.map_flags = {}, {}
        for name, (content, flags) in maps().items():
            self.files[name], self.map_flags[name] = content, flags
        self.files |= {"plan.toml": PLAN.encode(), "foreign.csv": FOREIGN.encode(), "pairs.csv": PAIRS.encode()}
        for name, content in self.files.items():
            with open(os.path.join(folder, name), "wb") as f:
                f.write(content)
        sparse = "--sigma 0,30 --step 3 --aperture 4"
        for line, name in (
            ("model ggx --set alpha=0.3 --ior 1.49 -o ggx.json", "ggx.json"),
            ("model ggx --opaque --set alpha=0.3 gain=0.5 lambert=0.02 -o metal.json", "metal.json"),
            ("model normals --set delta=0.2 n=2 --law gauss --ior 1.49 -o normals.json", "normals.json"),
            ("model heights --set delta=0.2 --law gauss --ior 1.49 -o heights.json", "heights.json"),
            ("model measured-ray --set scale=1 --map m.txt --ior 1.49 -o ray.json", "ray.json"),
            ("model measured-wave --set scale=1 --map m.txt --wavelength-nm 550 --ior 1.49 -o wave.json", "wave.json"),
            (f"scan ggx.json {sparse} -o scan.csv", "scan.csv"),
            (f"scan metal.json --geometry reflection {sparse} -o metal.csv", "metal.csv"),
            ("tabulate ggx.json --bytes 8192 -o ggx.bsdft", "ggx.bsdft"),
        ):
            done = subprocess.run([program, *line.split()], cwd=folder, capture_output=True, text=True)
            path = os.path.join(folder, name)
            if os.path.exists(path):
                with open(path, "rb") as f:
                    self.files[name] = f.read()
            else:
                print(f"note: no seed {name}: {done.stderr.strip()[:200]}", file=sys.stderr)


# What is run: the line, its outputs. {map} stands for a map with its flags.
LIGHT = "--ior 1.49 --rays 500"
LINES = [
    ("stats {map}", []),
    ("stats {map} --json --fill harmonic", []),
    ("stats {map} --ior 1.49 --wavelength-nm 550", []),
    ("stats {map} --plot s", ["s-map.svg", "s-map.png", "s-histogram.svg", "s-histogram.png", "s-spectrum.svg",
                              "s-spectrum.png"]),
    ("check --map {map} --incidence 0,60 " + LIGHT, []),
    ("check --map {map} --method wave --wavelength-nm 550 --incidence 0,30 " + LIGHT, []),
    ("scan --map {map} --method ray --sigma 0 --step 5 --aperture 4 -o out.csv " + LIGHT, ["out.csv"]),
    ("scan --map {map} --method wave --wavelength-nm 550 --sigma 0 --step 5 --ior 1.49 -o out.csv", ["out.csv"]),
    ("model measured-ray --set scale=1 --map {map} --ior 1.49 -o out.json", ["out.json"]),
    ("fit scan.csv --method measured-ray --map {map} --fit-rays 500 --rays 500 --ior 1.49 -o out.json", ["out.json"]),
    ("check ggx.json --incidence 0,60", []),
    ("check normals.json --incidence 30", []),
    ("check heights.json --incidence 30 --rays 200", []),
    ("check ray.json --incidence 30 --rays 200", []),
    ("check wave.json --incidence 30", []),
    ("check ggx.bsdft --incidence 30", []),
    ("eval ggx.json --input pairs.csv -o out.csv", ["out.csv"]),
    ("eval ggx.bsdft --input pairs.csv", []),
    ("eval ray.json --input pairs.csv --rays 500", []),
    ("scan ggx.json --sigma 0,30 --step 5 -o out.csv", ["out.csv"]),
    ("scan metal.json --geometry reflection --sigma 30 --step 5", []),
    ("scan ggx.bsdft --sigma 30 --step 5", []),
    ("fit scan.csv --method ggx --ior 1.49 -o out.json --json", ["out.json"]),
    ("fit scan.csv --method normals --ior 1.49", []),
    ("fit metal.csv --method ggx --opaque", []),
    ("fit foreign.csv --columns sigma=a,theta=b,reading=c --quantity bsdf --method ggx --opaque --aperture 0", []),
    ("compare scan.csv --methods ggx --ior 1.49 -o r", ["r"]),
    ("tabulate ggx.json --bytes 8192 -o out.bsdft --c out.h --rust out.rs", ["out.bsdft", "out.h", "out.rs"]),
    ("tabulate ray.json --bytes 8192 --rays 2000 -o out.bsdft", ["out.bsdft"]),
    ("trade ggx.json --sizes 2 --csv out.csv", ["out.csv"]),
    ("acquire --plan plan.toml --dry-run", []),
    ("acquire --port tcp:127.0.0.1:9 --plan plan.toml -o out.csv", ["out.csv", "out.csv.journal"]),
    ("model ggx --set alpha=0.3 --ior 1.49 -o out.json", ["out.json"]),
    ("model normals --set delta=0.2 n=2 --law gauss --ior 1.49", []),
]

WORDS = ["0", "-0", "-1", "1e308", "-1e308", "1e-308", "1e400", "nan", "inf", "-inf", "65536", "4294967295",
         "4294967296", "18446744073709551615", "-9223372036854775808", "9" * 400, "0.1.2", "1e", "", " ", "\u00b5",
         "\x1b[2J", "\ufffd", "null", "true", "[]", "{}", '"', "\\", "../../x", "/dev/null", "x" * 5000, "1,5", "0x10",
         "um", "nm", "m", "\u2028", "NaN", "1_000", "\u0661"]
LONGS = [0, 1, 0x7f, 0xff, 0x7fff, 0x8000, 0xffff, 1 << 20, 1 << 28, 0x7fffffff, 0x80000000, 0xffffffff, (1 << 63) - 1,
         1 << 63, (1 << 64) - 1]
NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def mutated(rng, data, others):
    """The file with one to four wounds."""
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(12)
        if kind == 0 and data:
            data[at % len(data)] ^= 1 << rng.randrange(8)
        elif kind == 1 and data:
            data[at % len(data)] = rng.randrange(256)
        elif kind == 2:
            del data[at:]
        elif kind == 3:
            del data[at:at + rng.choice((1, 2, 16, 200))]
        elif kind == 4:
            data[at:at] = data[at:at + rng.choice((1, 8, 300))]
        elif kind == 5:
            data[at:at] = bytes(rng.randrange(256) for _ in range(rng.choice((1, 4, 32))))
        elif kind == 6:
            form = rng.choice(("<H", ">H", "<I", ">I", "<Q", ">Q"))
            word = struct.pack(form, rng.choice(LONGS) & ((1 << 8 * struct.calcsize(form)) - 1))
            data[at:at + len(word)] = word
        elif kind in (7, 8, 9):
            # the first numbers are those of headers
            found = list(NUMBER.finditer(bytes(data)))[: rng.choice((6, 40, 4000))]
            if found:
                where = rng.choice(found)
                data[where.start():where.end()] = rng.choice(WORDS).encode()
        elif kind == 10:
            lines = bytes(data).split(b"\n")
            a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
            if rng.random() < 0.5:
                lines[a], lines[b] = lines[b], lines[a]
            else:
                lines.insert(a, lines[b])
            data = bytearray(b"\n".join(lines))
        else:
            other = rng.choice(others)
            cut = rng.randrange(len(other) + 1)
            data[at:] = other[cut:cut + 4096]
    return bytes(data)


def wounded_line(rng, line):
    """The line with the value of a flag replaced, a flag doubled or left out."""
    words = line.split()
    at = [k for k in range(1, len(words)) if words[k - 1].startswith("--") and not words[k].startswith("--")]
    kind = rng.randrange(4)
    if kind == 3 and len(words) > 2:
        del words[rng.randrange(1, len(words))]
    elif at:
        k = rng.choice(at)
        if kind == 2 and "," not in words[k]:
            words[k] = NUMBER.sub(lambda _: rng.choice(WORDS).encode(), words[k].encode(), count=1).decode()
        elif "=" in words[k]:
            words[k] = words[k].split("=")[0] + "=" + rng.choice(WORDS)
        else:
            words[k] = rng.choice(WORDS)
    # who asks for billions of rays gets them
    for k in range(1, len(words)):
        if words[k - 1] in ("--rays", "--fit-rays") and re.fullmatch(r"\d{6,}", words[k]):
            words[k] = "10000"
    return [w.replace("\0", "") for w in words]


class Case:
    def __init__(self, seeds, seed, number):
        rng = random.Random(f"{seed}:{number}")
        # plots and comparisons take a hundred times as long as all else
        weights = [1 if "--plot" in line or line.startswith(("compare", "trade")) else 8 for line, _ in LINES]
        line, self.outputs = rng.choices(LINES, weights)[0]
        names = list(seeds.files)
        if "{map}" in line:
            name = rng.choice(list(seeds.map_flags))
            line = line.replace("{map}", f"{name} {seeds.map_flags[name]}")
        used = [n for n in names if n in line.split()]
        if {"ray.json", "wave.json"} & set(used):
            used.append("m.txt")
        self.files = {n: seeds.files[n] for n in used}
        self.words = line.split()
        if used and rng.random() < 0.8:
            name = rng.choice(used)
            self.files[name] = mutated(rng, self.files[name], list(seeds.files.values()))
        else:
            self.words = wounded_line(rng, line)

    def run(self, options):
        """What is wrong; nothing if all is well."""
        with tempfile.TemporaryDirectory(prefix="asperity-fuzz-") as folder:
            for name, content in self.files.items():
                with open(os.path.join(folder, name), "wb") as f:
                    f.write(content)
            # a shell sets the limits: to do it between fork and exec is not safe beside threads
            limits = f'ulimit -v {options.memory_mib << 10}; ulimit -S -t {options.cpu}; ulimit -c 0; exec "$0" "$@"'
            command = ["sh", "-c", limits, options.program, *self.words]
            env = {**os.environ, "RAYON_NUM_THREADS": "1", "TMPDIR": folder, "RUST_BACKTRACE": "0"}
            try:
                done = subprocess.run(command, cwd=folder, env=env, stdin=subprocess.DEVNULL, capture_output=True,
                                      timeout=20 * options.cpu)
            except subprocess.TimeoutExpired:
                return [f"is not done after {20 * options.cpu} s, with less than {options.cpu} s of a core"], None
            except (ValueError, OSError) as e:  # what no shell could start either
                return [], f"not started: {e}"
            return self.judged(folder, done), done.returncode

    def judged(self, folder, done):
        wrong = []
        error = done.stderr.decode(errors="replace")
        if done.returncode not in (0, 1, 2):
            why = "too much time" if done.returncode == -signal.SIGXCPU else error[-300:]
            wrong.append(f"status {done.returncode}: {why}")
        if "panicked" in error or "overflow" in error and "attempt to" in error:
            wrong.append(f"panic: {error[-300:]}")
        if done.returncode == 2 and not error.strip():
            wrong.append("status 2 without a word")
        if len(error) > 20_000:
            wrong.append(f"{len(error)} bytes of messages")
        for name, content in self.files.items():
            path = os.path.join(folder, name)
            if not os.path.isfile(path) or open(path, "rb").read() != content:
                wrong.append(f"input {name} changed")
        asked = set(self.outputs) | set(self.words)
        for name in os.listdir(folder):
            if name in self.files:
                continue
            if done.returncode == 2:
                wrong.append(f"status 2 leaves {name}")
            elif name not in asked and not any(name.startswith(w) for w in asked if w not in ("", ".")):
                wrong.append(f"leaves {name}")
            elif ".part" in name or ".tmp" in name:
                wrong.append(f"leaves the temporary file {name}")
        return wrong

    def keep(self, where, number, wrong):
        folder = os.path.join(where, str(number))
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        for name, content in self.files.items():
            with open(os.path.join(folder, name), "wb") as f:
                f.write(content)
        with open(os.path.join(folder, "LINE"), "w", encoding="utf-8", errors="replace") as f:
            f.write(repr(self.words) + "\n" + "\n".join(wrong) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--program", default="target/debug/asperity")
    parser.add_argument("--count", type=int, default=25_000)
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first input")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="run one input and print it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--cpu", type=int, default=30, help="seconds of a core a run")
    parser.add_argument("--memory-mib", type=int, default=2048, help="address space of a run")
    parser.add_argument("--artifacts", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "artifacts/verbs"))
    options = parser.parse_args()
    options.program = os.path.abspath(options.program)
    if not os.access(options.program, os.X_OK):
        sys.exit(f"{options.program} cannot be run; build it: cargo build -p asperity")
    with tempfile.TemporaryDirectory() as folder:
        seeds = Seeds(options.program, folder)
    if options.only is not None:
        case = Case(seeds, options.seed, options.only)
        wrong, status = case.run(options)
        case.keep(options.artifacts, options.only, wrong)
        print(case.words, "status", status, *wrong, sep="\n")
        return 1 if wrong else 0
    lock, found, statuses, begun = threading.Lock(), [], {}, time.time()

    def one(number):
        case = Case(seeds, options.seed, number)
        wrong, status = case.run(options)
        with lock:
            statuses[status] = statuses.get(status, 0) + 1
            if wrong:
                found.append(number)
                case.keep(options.artifacts, number, wrong)
                print(f"{number}: {' '.join(case.words)[:200]}\n    {'; '.join(wrong)[:600]}", flush=True)
            done = sum(statuses.values())
            if done % 1000 == 0:
                print(f"{done} inputs, {time.time() - begun:.0f} s, {len(found)} findings", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(one, range(options.first, options.first + options.count)))
    shown = ", ".join(f"{status}: {n}" for status, n in sorted(statuses.items(), key=str))
    print(f"{options.count} inputs, seed {options.seed}, {time.time() - begun:.0f} s; ended with {shown}")
    print(f"{len(found)} findings" + (f", kept in {options.artifacts}" if found else ""))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
