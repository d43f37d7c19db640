"""Scans, balances, fits on maps and comparisons: the same figures as the command line prints."""

import json
import subprocess

import asperity
import numpy as np
import pytest

GGX = '{"asperity": 1, "method": "ggx", "ior": 1.49, "parameters": {"alpha": {"value": 0.2}}}'


class Work:
    """A folder, and the program run in it."""

    def __init__(self, folder, program):
        self.folder, self.program = folder, program

    def __truediv__(self, name):
        return self.folder / name

    def run(self, *arguments):
        line = [self.program, *map(str, arguments)]
        return subprocess.run(line, capture_output=True, cwd=self.folder, check=True).stdout.decode()


@pytest.fixture(scope="session")
def work(tmp_path_factory, program):
    """A folder with a model, its table, a map, and scans of the model, written by the program."""
    folder = Work(tmp_path_factory.mktemp("work"), program)
    (folder / "ggx.json").write_text(GGX)
    y, x = np.mgrid[0:64, 0:64] * (2 * np.pi / 64)
    heights = 0.15 * (np.sin(5 * x) + np.sin(3 * x + 4 * y) + np.cos(5 * y))
    np.save(folder / "map.npy", heights)
    folder.run("tabulate", "ggx.json", "-o", "ggx.bsdft", "--bytes", 8192)
    folder.run("scan", "ggx.json", "--sigma", "0,40", "--step", 0.5, "-o", "scan.csv")
    return folder


def subjects(work):
    """Each kind of subject, as Python and as the command line name it."""
    chart = asperity.read_map(work / "map.npy", pixel_um=0.5)
    on_map = ["--map", "map.npy", "--pixel-um", 0.5, "--ior", 1.5]
    waves = ["--method", "wave", "--wavelength-nm", 550]
    return {
        "model": (asperity.Model.load(work / "ggx.json"), {}, ["ggx.json"]),
        "table": (asperity.Table.load(work / "ggx.bsdft"), {}, ["ggx.bsdft"]),
        "rays": (chart, {"ior": 1.5}, on_map),
        "waves": (chart, {"ior": 1.5, "engine": "wave", "wavelength_nm": 550}, on_map + waves),
    }


@pytest.mark.parametrize("kind", ["model", "table", "rays", "waves"])
def test_a_scan_is_that_of_the_command_line(work, kind):
    of, named, arguments = subjects(work)[kind]
    rays = {"rays": 20_000} if kind == "rays" else {}
    flags = ["--rays", 20_000] if kind == "rays" else []
    found = asperity.scan(of, sigma_deg=[0, 40], theta_deg=(-60, 60), step_deg=2, **rays, **named)
    text = work.run("scan", *arguments, "--sigma", "0,40", "--theta-range=-60:60", "--step", 2, *flags)
    path = work / "printed.csv"
    path.write_text(text)
    right = asperity.read_scan(path)
    np.testing.assert_array_equal(found.theta_deg, right.theta_deg)
    np.testing.assert_allclose(found.reading, right.reading, rtol=1e-9)  # files have ten digits
    named_by_path = ("sample",)
    assert {k: v for k, v in found.meta.items() if k not in named_by_path} == {
        k: v for k, v in right.meta.items() if k not in named_by_path
    }


@pytest.mark.parametrize("kind", ["model", "table", "rays", "waves"])
def test_a_balance_is_that_of_the_command_line(work, kind):
    of, named, arguments = subjects(work)[kind]
    rays = {"rays": 20_000} if kind == "rays" else {}
    flags = ["--rays", 20_000] if kind == "rays" else []
    found = asperity.check(of, incidences_deg=[0, 50], **rays, **named)
    assert found == json.loads(work.run("check", *arguments, "--incidence", "0,50", "--json", *flags))


def test_a_map_is_fitted_as_the_command_line_does_it(work):
    chart = asperity.read_map(work / "map.npy", pixel_um=0.5)
    assert chart.heights_um.shape == (64, 64) and chart.pitch_um == (0.5, 0.5)
    assert chart.roughness()["rq_um"] > 0.1
    assert "measured" not in repr(chart)
    scan = asperity.read_scan(work / "scan.csv")
    rays = {"fit_rays": 20_000, "rays": 20_000}
    model = asperity.fit(scan, "measured-ray", map=chart, cutoff=False, max_evaluations=40, **rays)
    try:
        work.run(
            *("fit", "scan.csv", "--method", "measured-ray", "--map", "map.npy", "--pixel-um", 0.5),
            *("--no-cutoff", "--fit-rays", 20_000, "--rays", 20_000, "--max-evaluations", 40, "-o", "fit.json"),
        )
    except subprocess.CalledProcessError as no:
        # a lattice of bumps is no GGX: the answer is no, and the fit is written
        assert no.returncode == 1
    right = asperity.Model.load(work / "fit.json")
    assert model.parameters == pytest.approx(right.parameters, rel=1e-12)
    assert model.warnings == right.warnings and model.rmsd_percent == pytest.approx(right.rmsd_percent)
    with pytest.raises(ValueError, match="give map=read_map"):
        asperity.fit(scan, "measured-ray")
    with pytest.raises(ValueError, match="give wavelength_nm"):
        asperity.fit(scan, "measured-wave", map=chart)
    with pytest.raises(ValueError, match="has no map; leave it out"):
        asperity.fit(scan, "ggx", map=chart)


def test_a_comparison_is_that_of_the_command_line(work):
    scan = asperity.read_scan(work / "scan.csv")
    found = asperity.compare([scan], names=["scan"], methods=["ggx", "normals", "measured-ray"])
    printed = work.run(
        *("compare", "scan.csv", "--methods", "ggx,normals,measured-ray"),
        *("--json", "--no-timing", "-o", "compared"),
    )
    right = json.loads(printed)
    (mine,), (theirs,) = found["samples"], right["samples"]
    for a, b in zip(mine["results"][:2], theirs["results"][:2]):
        assert a == b
    assert mine["results"][2]["notes"] == ["method measured-ray needs a height map; give map=read_map(FILE)"]
    assert theirs["results"][2]["notes"] == ["method measured-ray needs a height map; give --map FILE"]
    assert mine["best"] == theirs["best"] == "ggx" and mine["verdict"] == theirs["verdict"]


def test_what_cannot_be_measured_is_refused_with_the_argument_that_mends_it(work):
    model = asperity.Model.load(work / "ggx.json")
    chart = asperity.read_map(work / "map.npy", pixel_um=0.5)
    for call, words in [
        (lambda: asperity.scan(model, sigma_deg=[95]), "an incidence of 95 degrees"),
        (lambda: asperity.scan(model, rays=0), "rays is 0"),
        (lambda: asperity.scan(model, rays=1000, aperture_deg=0, quantity="bsdf"), "give aperture_deg above 0"),
        (lambda: asperity.scan(model, ior=1.5), "are for a map"),
        (lambda: asperity.scan(chart), "a map needs ior"),
        (lambda: asperity.scan(chart, ior=1.5, engine="wave"), "give wavelength_nm"),
        (lambda: asperity.scan(chart, ior=1.5, wavelength_nm=550), "rays have no wavelength"),
        (lambda: asperity.scan(chart, ior=1.5, engine="magic"), "engine"),
        (lambda: asperity.check(model, incidences_deg=[90]), "an incidence of 90 degrees"),
        (lambda: asperity.check(model, side="inside"), "side"),
        (lambda: asperity.read_map(work / "map.npy", fill="guess"), "fill"),
    ]:
        with pytest.raises(ValueError, match=words):
            call()
    with pytest.raises(FileNotFoundError):
        asperity.read_map(work / "no.npy")
