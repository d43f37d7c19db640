#!/usr/bin/env python3
"""Compares files for Radiance and Mitsuba with what these programs read from them.

    mkdir files
    ASPERITY_PEER_FILES=$PWD/files cargo test -p asperity-exchange for_peers
    pip install pyradiance mitsuba
    python tests/peers/radiance.py files

Each file has two tables beside it: values of the file and of the law at pairs of directions (degrees, polar angle from +z, the air), and
the scattered flux of incidences. Radiance: `query` and `direct_hemi` of pyradiance, `checkBSDF`, `bsdf2klems` of a tree. Mitsuba: `eval` in both
transport modes. The exit code is 1 if a value is off by more than is said below.
"""
import csv
import math
import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as xml

# relative to the largest value of a file: Radiance stores 4-byte floats and takes a Lambertian part off
VALUE, FLUX, MITSUBA = 5e-4, 1e-4, 1e-5
ANGLES = ("theta_in_deg", "phi_in_deg", "theta_out_deg", "phi_out_deg")


def table(path):
    with open(path) as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def radiance(path, stem):
    import pyradiance
    import pyradiance.bsdf as bsdf

    data = bsdf.load_file(str(path))
    pairs = [r for r in table(f"{stem}.pairs.csv") if abs(r["theta_out_deg"] - 90) > 1e-3]
    top = max(r["file"] for r in pairs) or 1.0
    seen = [float(bsdf.query(data, *(r[a] for a in ANGLES))[1]) for r in pairs]
    value = max(abs(s - r["file"]) for s, r in zip(seen, pairs)) / top
    law = max(abs(s - r["law"]) for s, r in zip(seen, pairs)) / top
    peak = max(pairs, key=lambda r: r["law"])
    at_peak = float(bsdf.query(data, *(peak[a] for a in ANGLES))[1]) / peak["law"] - 1 if peak["law"] > 0 else 0.0
    flux = 0.0
    for r in table(f"{stem}.flux.csv"):
        front = r["theta_in_deg"] < 90
        kind = bsdf.SAMPLE_R if "reflection" in stem else bsdf.SAMPLE_T
        total = bsdf.direct_hemi(data, r["theta_in_deg"], r["phi_in_deg"], kind | (bsdf.SAMPLE_ALL & ~bsdf.SAMPLE_R & ~bsdf.SAMPLE_T))
        if r["flux"] > 1e-3:
            flux = max(flux, abs(total / r["flux"] - 1))
    print(
        f"{path.name}: {len(pairs)} pairs, value {100 * value:.4f} % of the largest, flux {100 * flux:.4f} %; "
        f"from the law at centres {100 * law:.2f} %, at the largest {100 * at_peak:+.2f} %"
    )
    tools = pathlib.Path(pyradiance.__file__).parent / "bin"
    env = {**os.environ, "RAYPATH": str(tools.parent / "lib")}
    report = subprocess.run([tools / "checkBSDF", path], capture_output=True, text=True, env=env)
    for line in report.stdout.splitlines():
        if line.startswith("Type") or "%" in line and "180" not in line and "Component" not in line:
            print("   ", " ".join(line.split()))
    if "tensortree" in path.name:
        klems = subprocess.run([tools / "bsdf2klems", "-n", "64", path], capture_output=True, text=True, env=env)
        out = path.with_suffix(".klems.xml.tmp")
        out.write_text(klems.stdout)
        count = klems.stdout.count("<WavelengthDataBlock>")
        print(f"    bsdf2klems: exit {klems.returncode}, {count} blocks")
        out.unlink()
    return value < VALUE and flux < FLUX


def direction(theta, phi):
    theta, phi = math.radians(theta), math.radians(phi)
    return [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]


def mitsuba(path, stem):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    element = xml.parse(path).getroot().find("bsdf")
    index = float(element.find("float[@name='int_ior']").get("value"))
    element.set("version", "3.0.0")
    material = mi.load_string(xml.tostring(element, encoding="unicode"))
    pairs = table(f"{stem}.pairs.csv")
    top = max(r["law"] for r in pairs)
    worst = {}
    for r in pairs:
        source = direction(r["theta_in_deg"], r["phi_in_deg"])
        out = direction(r["theta_out_deg"], r["phi_out_deg"])
        scale = 1.0
        if source[2] * out[2] < 0:
            scale = index**-2 if out[2] < 0 else index**2
        for name, mode, wi, wo, ought in (
            # light from its source; a path of the camera, which comes from where the light leaves to; eval of it the other way round
            ("importance", mi.TransportMode.Importance, source, out, r["law"]),
            ("radiance", mi.TransportMode.Radiance, out, source, r["law"]),
            ("radiance, wi at the source", mi.TransportMode.Radiance, source, out, r["law"] * scale),
        ):
            si = mi.SurfaceInteraction3f()
            si.wi = mi.Vector3f(wi)
            value = material.eval(mi.BSDFContext(mode), si, mi.Vector3f(wo))[0] / abs(wo[2])
            worst[name] = max(worst.get(name, 0.0), abs(value - ought) / top)
    print(f"{path.name}: {len(pairs)} pairs, " + ", ".join(f"{k} {100 * v:.5f} % of the largest" for k, v in worst.items()))
    return max(worst.values()) < MITSUBA


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path = pathlib.Path(sys.argv[1])
    if path.is_dir():
        # a process each: the two programs do not share one well
        codes = [subprocess.run([sys.executable, __file__, file]).returncode for file in sorted(path.glob("*.xml"))]
        sys.exit(any(codes))
    read = mitsuba if path.name.startswith("mitsuba") else radiance
    sys.exit(0 if read(path, str(path.with_suffix(""))) else 1)


if __name__ == "__main__":
    main()
