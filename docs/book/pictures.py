#!/usr/bin/env python3
"""Makes the pictures of the methods from what the program computes: docs/book/pictures.py PROGRAM DEMO [METHOD...]

PROGRAM is a release build of asperity, DEMO the folder that `asperity demo` wrote (its map is used). Takes a minute; standard library
only. The pictures are written to docs/book/src/pictures, each with its commands as a description.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

PICTURES = pathlib.Path(__file__).parent / "src" / "pictures"
COLOURS = ("#1b6ca8", "#c0392b", "#3a8f4d", "#8e5ea2")
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 380, 300, 58, 34, 12, 46


class Panel:
    """Curves over an angle with a logarithmic ordinate."""

    def __init__(self, title, abscissa, ordinate, x, decades):
        self.title, self.abscissa, self.ordinate = title, abscissa, ordinate
        self.x, self.decades = x, decades
        self.curves = []

    def add(self, points, colour, label=None, dashed=False):
        self.curves.append((points, colour, label, dashed))

    def place(self, x, y):
        (x0, x1), (d0, d1) = self.x, self.decades
        across, down = (x - x0) / (x1 - x0), (d1 - math.log10(y)) / (d1 - d0)
        return LEFT + across * (WIDTH - LEFT - RIGHT), TOP + down * (HEIGHT - TOP - BOTTOM)

    def runs(self, points):
        """The parts of a curve inside the panel, without points that nobody would miss."""
        run = []
        for x, y in [*points, (math.nan, math.nan)]:
            if self.x[0] <= x <= self.x[1] and 10 ** self.decades[0] <= y <= 10 ** self.decades[1]:
                run.append(self.place(x, y))
            else:
                if len(run) > 1:
                    yield simplified(run)
                run = []

    def svg(self, shift):
        parts = [f'<g transform="translate({shift},0)">']
        left, right, bottom = LEFT, WIDTH - RIGHT, HEIGHT - BOTTOM
        parts.append(f'<text x="{(left + right) / 2:g}" y="20" text-anchor="middle" font-weight="bold">{self.title}</text>')
        grid, labels = [], []
        for decade in range(self.decades[0], self.decades[1] + 1):
            y = self.place(self.x[0], 10**decade)[1]
            grid.append(f"M{left} {y:.1f}H{right}")
            labels.append(f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{10.0**decade:g}</text>')
        for x in range(self.x[0], self.x[1] + 1, 30 if self.x[1] - self.x[0] > 90 else 10):
            at = self.place(x, 10 ** self.decades[0])[0]
            grid.append(f"M{at:.1f} {TOP}V{bottom}")
            labels.append(f'<text x="{at:.1f}" y="{bottom + 16}" text-anchor="middle">{x}</text>')
        parts.append(f'<path d="{"".join(grid)}" stroke="#ddd" fill="none"/>')
        parts += labels
        parts.append(f'<text x="{(left + right) / 2:g}" y="{HEIGHT - 8}" text-anchor="middle">{self.abscissa}</text>')
        middle = (TOP + bottom) / 2
        parts.append(f'<text transform="translate(14,{middle:g}) rotate(-90)" text-anchor="middle">{self.ordinate}</text>')
        line = TOP + 14
        for points, colour, label, dashed in self.curves:
            dash = ' stroke-dasharray="4 3"' if dashed else ""
            path = "".join("M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in run) for run in self.runs(points))
            parts.append(f'<path d="{path}" stroke="{colour}" fill="none" stroke-width="1.6"{dash}/>')
            if label:
                parts.append(f'<text x="{left + 6}" y="{line}" fill="{colour}">{label}</text>')
                line += 15
        parts.append("</g>")
        return "\n".join(parts)


def simplified(run, tolerance=0.3):
    """A line with fewer corners that nowhere differs by more than the tolerance [Ramer, Douglas and Peucker]."""
    (x0, y0), (x1, y1) = run[0], run[-1]
    length = math.hypot(x1 - x0, y1 - y0) or 1.0
    off = [abs((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / length for x, y in run]
    far = max(range(len(run)), key=off.__getitem__)
    if off[far] <= tolerance:
        return [run[0], run[-1]]
    return simplified(run[: far + 1], tolerance)[:-1] + simplified(run[far:], tolerance)


def write(name, title, panels, commands):
    said = "\n".join(commands)
    body = "\n".join(panel.svg(k * WIDTH) for k, panel in enumerate(panels))
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {len(panels) * WIDTH} {HEIGHT}" '
        f'font-family="sans-serif" font-size="12">\n<title>{title}</title>\n<desc>made by docs/book/pictures.py from\n{said}</desc>\n'
        f'<rect width="100%" height="100%" fill="#fff"/>\n{body}\n</svg>\n'
    )
    (PICTURES / f"{name}.svg").write_text(text)
    print(f"{name}.svg: {len(text)} bytes")


class Program:
    """The program in a folder of its own, with a record of what it was asked."""

    def __init__(self, path, folder):
        self.path, self.folder, self.commands = path, folder, []

    def run(self, *arguments, given=None):
        self.commands.append("asperity " + " ".join(arguments))
        done = subprocess.run([self.path, *arguments], input=given, capture_output=True, text=True, cwd=self.folder)
        if done.returncode > 1:
            sys.exit(f"{self.commands[-1]}:\n{done.stderr}")
        return done.stdout

    def model(self, name, *arguments):
        self.run("model", *arguments, "-o", name)
        return name

    def lobes(self, model, side, incidence_deg):
        """(angle, ars) of the reflected and the transmitted light in the plane of incidence; angles from the normal of each side."""
        sign = 1.0 if side == "air" else -1.0
        s, c = math.sin(math.radians(incidence_deg)), math.cos(math.radians(incidence_deg))
        angles = [a / 2 for a in range(-179, 180)]
        rows = ["wix,wiy,wiz,wox,woy,woz"]
        for lobe in (1.0, -1.0):
            for angle in angles:
                x, z = math.sin(math.radians(angle)), math.cos(math.radians(angle))
                rows.append(f"{-s},0,{sign * c},{x},0,{lobe * sign * z}")
        lines = self.run("eval", model, given="\n".join(rows) + "\n").splitlines()
        column = lines[0].split(",").index("ars")
        values = [float(line.split(",")[column]) for line in lines[1:]]
        return list(zip(angles, values)), list(zip(angles, values[len(angles) :]))

    def readings(self, model, *arguments):
        """(angle, reading) of a scan."""
        self.run("scan", model, *arguments, "-o", "scan.csv")
        lines = (pathlib.Path(self.folder) / "scan.csv").read_text().splitlines()
        rows = [line.split(",") for line in lines if line and line[0] in "-0123456789"]
        return [(float(theta), float(reading)) for _, theta, reading in rows]


def lobes(program, name, title, models):
    """Light from the air and from inside, of several models."""
    files = [(program.model(f"{k}.json", *arguments), label) for k, (label, arguments) in enumerate(models)]
    panels = []
    for side, words in (("air", "from the air at 30°"), ("dielectric", "from inside at 30°")):
        panel = Panel(words, "angle from the normal, °", "f |cos θ|, 1/sr", (-90, 90), (-3, 2))
        for (file, label), colour in zip(files, COLOURS):
            reflected, transmitted = program.lobes(file, side, 30)
            panel.add(transmitted, colour, label)
            panel.add(reflected, colour, dashed=True)
        panels.append(panel)
    write(name, f"{title}; solid: transmitted, dashed: reflected", panels, program.commands)


def scans(program, name, title, models, decades, *arguments):
    """What the instrument reads behind the plate, at two incidences."""
    files = [(program.model(f"{k}.json", *made), label) for k, (label, made) in enumerate(models)]
    panels = []
    for sigma in (0, 40):
        panel = Panel(f"incidence {sigma}°", "angle of observation, °", "reading", (sigma - 30, sigma + 30), decades)
        for (file, label), colour in zip(files, COLOURS):
            panel.add(program.readings(file, "--sigma", str(sigma), "--step", "0.5", *arguments), colour, label)
        panels.append(panel)
    write(name, title, panels, program.commands)


PLATE = ("--ior", "1.49")
MAP = ("--map", "demo/virtual/map.sdf", *PLATE)
LIGHT = ("--wavelength-nm", "550")
RAYS = ("--rays", "4e5", "--seed", "1")


def ggx(program):
    widths = [(f"alpha {a}", ("ggx", "--set", f"alpha={a}", *PLATE)) for a in (0.1, 0.2, 0.4)]
    lobes(program, "ggx", "GGX of three widths", widths)


def normals(program):
    def one(profile, n):
        return f"{profile}, n = {n}", ("normals", "--profile", profile, "--set", "delta=8", f"n={n}", *PLATE)

    lobes(program, "normals", "three densities of normals", [one("gauss", 2), one("gauss", 4), one("cauchy", 3)])


def beckmann(program):
    widths = [(f"alpha {a}", ("beckmann", "--set", f"alpha={a}", *PLATE)) for a in (0.1, 0.2, 0.4)]
    lobes(program, "beckmann", "Beckmann of three widths", widths)


def student(program):
    tails = [(f"gamma {g}", ("student", "--set", "sigma=0.2", f"gamma={g}", *PLATE)) for g in (1.6, 2, 4, 50)]
    lobes(program, "student", "Student-t of four tails", tails)


def smith_normals(program):
    def one(profile, n):
        return f"{profile}, n = {n}", ("smith-normals", "--profile", profile, "--set", "delta=8", f"n={n}", *PLATE)

    lobes(program, "smith-normals", "three densities with masking", [one("gauss", 2), one("gauss", 4), one("cauchy", 3)])


def slopes(program):
    def one(label, *logs):
        knots = [f"knot{k + 1}={log}" for k, log in enumerate(logs)]
        return label, ("slopes", "--set", "width=0.6", *knots, *PLATE)

    shapes = [
        one("a bell", -0.2, -0.8, -1.8, -3.2, -5, -7.2, -9.8),
        one("a flat top", 0, 0, -0.2, -3, -6, -8, -10),
        one("a ring", 0.5, 1, 0.6, -1.5, -4, -6, -8),
    ]
    lobes(program, "slopes", "three densities of slopes through knots", shapes)


def about_specular(program, name, title, models):
    """Scatter of sheets, at two incidences."""
    files = [(program.model(f"{k}.json", name, "--lobe", "transmission", *made), label) for k, (label, made) in enumerate(models)]
    panels = []
    for deg in (0, 40):
        panel = Panel(f"incidence {deg}°", "angle from the normal, °", "f |cos θ|, 1/sr", (-90, 90), (-4, 2))
        for (file, label), colour in zip(files, COLOURS):
            panel.add(program.lobes(file, "air", deg)[1], colour, label)
        panels.append(panel)
    write(name, title, panels, program.commands)


def abg(program):
    models = [(f"g = {g}", ("--set", f"A={a}", f"B={b}", f"g={g}")) for a, b, g in ((0.02, 0.01, 2), (0.003, 1e-3, 3), (2e-5, 1e-5, 6))]
    about_specular(program, "abg", "ABg of three tails", models)


def harvey(program):
    models = [(f"S = {s}, m = {m}", ("--set", "b0=3", "L=0.12", f"S={s}", f"m={m}")) for s, m in ((-2.2, 2), (-4, 2), (-4, 12))]
    about_specular(program, "harvey", "Harvey's law: two tails, and a sharper shoulder", models)


def k_correlation(program):
    models = [(f"C = {c}", ("--set", "A=0.01", "B=6", f"C={c}", "--wavelength-nm", "550", *PLATE)) for c in (2, 3, 5)]
    about_specular(program, "k-correlation", "three spectra of roughness", models)


def super_gauss(program):
    models = [(f"p = {p}", ("--set", "A=4", "w=0.2", f"p={p}")) for p in (1, 2, 8)]
    about_specular(program, "super-gauss", "super-Gaussians of three edges", models)


def heights(program):
    widths = [(f"delta {d}", ("heights", "--set", f"delta={d}", *PLATE)) for d in (0.1, 0.2, 0.3)]
    scans(program, "heights", "random heights of three widths", widths, (-5, -1), *RAYS)


def measured_ray(program):
    scales = [(f"scale {s}", ("measured-ray", *MAP, "--set", f"scale={s}", "cutoff_um=0")) for s in (0.5, 1, 2)]
    scans(program, "measured-ray", "rays on the map of the demonstration, its heights scaled", scales, (-5, -1), *RAYS)


def measured_wave(program):
    def one(scale):
        return f"Rq {0.7 * scale:.2f} um", ("measured-wave", *MAP, *LIGHT, "--set", f"scale={scale}", "cutoff_um=0")

    title = "waves on the same map: coherent light appears where it is smooth"
    scans(program, "measured-wave", title, [one(0.1), one(0.3), one(1)], (-6, 0))


def measured_hybrid(program):
    scaled = ("--set", "scale=0.3", "cutoff_um=0")
    engines = [
        ("rays", ("measured-ray", *MAP, *scaled)),
        ("waves", ("measured-wave", *MAP, *LIGHT, *scaled)),
        ("hybrid", ("measured-hybrid", *MAP, *LIGHT, *scaled)),
    ]
    title = "rays, waves and both on the same map, its heights scaled by 0.3"
    scans(program, "measured-hybrid", title, engines, (-6, 0), "--seed", "1")


def mix(program):
    def one(alpha):
        return "ggx", "--set", f"alpha={alpha}", *PLATE

    both = ("mix", "--of", "ggx,ggx", "--set", "alpha=0.05", "alpha2=0.4", "share2=0.3", "lambert=0.1", *PLATE)
    models = [("alpha 0.05", one(0.05)), ("alpha 0.4", one(0.4)), ("0.6 + 0.3, 0.1 diffuse", both)]
    lobes(program, "mix", "a sharp lobe, a wide one, and both with a diffuse share", models)


def bounces(program):
    """R of Smith's surface with all bounces beside that of rays on a Gaussian map of the same rms slopes; also as a table."""
    said = json.loads(program.run("stats", "demo/virtual/map.sdf", "--json"))
    slope = math.hypot(said["rms_slope_x"], said["rms_slope_y"]) / math.sqrt(2)
    angles = [0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85]
    panels = [Panel(words, "incidence, °", "R", (0, 90), (-2, 0)) for words in ("from the air", "from inside")]
    rows = {}
    for wanted, colour in ((0.3, COLOURS[0]), (0.7, COLOURS[1])):
        smith = program.model("smith.json", "beckmann", "--bounces", "all", "--set", f"alpha={wanted * math.sqrt(2):.4f}", *PLATE)
        rays = program.model("rays.json", "measured-ray", *MAP, "--set", f"scale={wanted / slope:.4f}", "cutoff_um=0")
        for label, model, dashed in ((f"slope {wanted}", smith, False), ("rays on a map", rays, True)):
            incidences = ",".join(map(str, angles))
            found = json.loads(program.run("check", model, "--incidence", incidences, "--rays", "200000", "--json"))
            for panel, side in zip(panels, ("air", "dielectric")):
                points = [(e["incidence_deg"], e["reflected"]) for e in found["energy"] if e["side"] == side]
                # where its curves leave room for it
                panel.add(points, colour, label if side == "air" else None, dashed)
                for deg, reflected in points:
                    rows.setdefault((side, wanted, deg), []).append(reflected)
    for (side, wanted, deg), (smith, rays) in rows.items():
        if deg in (0, 30, 60, 75):
            print(f"| {side} | {wanted} | {deg:g} | {smith:.3f} | {rays:.3f} | {smith - rays:+.3f} |")
    write("bounces", "R of all bounces; solid: Smith's surface, dashed: rays on a Gaussian map", panels, program.commands)


def atlas(program):
    """True errors over the incidence; the wavelength sets Rq in wavelengths."""
    rq = json.loads(program.run("stats", "demo/virtual/map.sdf", "--json"))["rq_um"]
    incidences = ",".join(str(deg) for deg in range(0, 61, 5))
    panels = [Panel(words, "incidence, °", "error, % of the peak", (0, 60), (-2, 2)) for words in ("transmitted", "reflected")]
    for height, colour in zip((0.2, 0.5, 1.2), COLOURS):
        light = ("--wavelength-nm", f"{1000 * rq / height:.0f}", "--incidence", incidences)
        said = json.loads(program.run("stats", "demo/virtual/map.sdf", *PLATE, *light, "--json"))["atlas"]["lobes"]
        for panel, lobe in zip(panels, ("transmission", "reflection")):
            mine = [row for row in said if (row["side"], row["lobe"]) == ("air", lobe)]
            for engine, dashed in (("kirchhoff", False), ("rays", True)):
                points = [(row["incidence_deg"], row[engine]["error_percent"]) for row in mine]
                panel.add(points, colour, None if dashed else f"Rq {height} wavelengths", dashed)
    write("atlas", "errors of waves (solid) and rays (dashed) in the atlas, light from the air", panels, program.commands)


METHODS = {
    "atlas": atlas,
    "ggx": ggx,
    "normals": normals,
    "beckmann": beckmann,
    "student": student,
    "smith-normals": smith_normals,
    "slopes": slopes,
    "bounces": bounces,
    "mix": mix,
    "abg": abg,
    "harvey": harvey,
    "k-correlation": k_correlation,
    "super-gauss": super_gauss,
    "heights": heights,
    "measured-ray": measured_ray,
    "measured-wave": measured_wave,
    "measured-hybrid": measured_hybrid,
}


def main():
    program, demo = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "demo").symlink_to(demo)
        for name in sys.argv[3:] or METHODS:
            METHODS[name](Program(program, folder))


main()
