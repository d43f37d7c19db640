"""Objects that go through pickle and copy, and arrays that are too large."""

import copy
import pickle
import subprocess

import asperity
import numpy as np
import pytest

UP = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.28, 0.0, -0.96]])
OUT = np.array([[0.1, -0.2, 0.9746794344808963], [-0.6, 0.0, 0.8], [0.0, 0.6, -0.8]])


def again(thing):
    return [pickle.loads(pickle.dumps(thing, protocol)) for protocol in range(2, 6)]


@pytest.mark.parametrize(
    "law",
    [
        asperity.Ggx(0.1 + 0.2, 1.49),
        asperity.Ggx(1e-6, 0.1),
        asperity.Normals(6.9, 1.66, ior=1.49),
        asperity.Normals(20 / 3, 2.2, 1 / 3, "cauchy", ior=1 / 1.5),
        asperity.Model.from_json(asperity.fit(
            asperity.Scan([0] * 41, list(range(-20, 21)), [float(np.exp(-t * t / 50)) for t in range(-20, 21)],
                          {"geometry": "transmission", "ior": 1.49, "rough_side": "source", "aperture_deg": 2})
        ).to_json()),
    ],
)
def test_a_law_is_the_same_after_a_pickle(law):
    for other in again(law):
        for single in (False, True):
            wi, wo = (UP.astype("f4"), OUT.astype("f4")) if single else (UP, OUT)
            assert repr(other) == repr(law)
            for what in ("eval", "ars", "pdf"):
                assert getattr(other, what)(wi, wo).tobytes() == getattr(law, what)(wi, wo).tobytes()
    assert copy.copy(law) is law and copy.deepcopy([law])[0] is law


def test_a_model_of_a_map_finds_it_again(program, tmp_path, monkeypatch):
    rng = np.random.default_rng(1)
    heights = 0.05 * rng.standard_normal((16, 16))
    np.savetxt(tmp_path / "map.txt", heights, header="heights in um")
    line = "model measured-ray --set scale=1 --map map.txt --pixel-um 0.5 --ior 1.5 -o m.json"
    subprocess.run([program, *line.split()], cwd=tmp_path, check=True)
    monkeypatch.chdir(tmp_path)
    model = asperity.Model.load("m.json")
    monkeypatch.chdir("/")
    for other in again(model):
        assert other.to_json() == model.to_json()
        wi = [0.0, 0.0, 1.0]
        assert other.eval(wi, OUT, rays=1000).tobytes() == model.eval(wi, OUT, rays=1000).tobytes()


def test_tables_and_scans_are_the_same_after_a_pickle(program, tmp_path):
    model = tmp_path / "m.json"
    subprocess.run([program, *"model ggx --set alpha=0.2 --ior 1.49 -o".split(), model], check=True)
    subprocess.run([program, "tabulate", model, "--bytes", "8192", "-o", tmp_path / "t.bsdft"], check=True)
    table = asperity.Table.load(tmp_path / "t.bsdft")
    for other in again(table):
        assert other.eval(UP, OUT).tobytes() == table.eval(UP, OUT).tobytes()
        assert (other.method, other.nbytes, other.distance_percent) == (table.method, table.nbytes, table.distance_percent)
    scan_file = tmp_path / "s.csv"
    subprocess.run([program, "scan", model, "--sigma", "0,30", "--step", "5", "-o", scan_file], check=True)
    read = asperity.read_scan(scan_file)
    made = asperity.Scan([0, 0], [1, 0], [0.1, 1 / 3], {"sample": "a: b", "Own key": "x", "ior": 1.49, "seed": 7})
    for scan in (read, made):
        for other in again(scan):
            assert other.meta == scan.meta and repr(other) == repr(scan)
            for what in ("sigma_deg", "theta_deg", "reading"):
                assert getattr(other, what).tobytes() == getattr(scan, what).tobytes()
    # the file goes along: a fit says what it was made from
    fits = [asperity.fit(scan, max_evaluations=50).to_json() for scan in (read, again(read)[0])]
    assert all(scan_file.name in fit for fit in fits)


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_what_does_not_fit_into_memory_is_a_memory_error(dtype):
    rows = np.broadcast_to(np.array([0, 0, 1], dtype), (10**12, 3))
    for law in (asperity.Ggx(0.2, 1.49), asperity.Normals(7.0, ior=1.49)):
        for what in (law.eval, law.ars, law.pdf):
            with pytest.raises(MemoryError, match="give fewer rows"):
                what(rows, rows[0])
        with pytest.raises(MemoryError):
            law.sample(rows, np.array([0.5, 0.5, 0.5], dtype))
        assert law.eval(rows[0], rows[0]) > 0


def test_messages_are_short():
    with pytest.raises(ValueError) as error:
        asperity.Ggx(1e300, 1.49)
    assert len(str(error.value)) < 200
    with pytest.raises(ValueError) as error:
        asperity.Model.from_json("x" * 100_000)
    assert len(str(error.value)) < 500
