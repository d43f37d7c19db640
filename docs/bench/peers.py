"""The other side of docs/bench/run: the same work, on the files of `peers`, by other programs."""

import os
import sys
import time

import numpy as np

SIDE = 1024
NAMES = {
    "ggx batch f32": "Mitsuba, llvm_ad_rgb, in its kernel",
    "first hit": "Embree",
    "transform": "scipy.fft.fft2, 2 workers",
}


def best(runs, count, work):
    """The shortest of some runs, ns for each of `count`."""
    work()
    found = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return 1e9 * min(found) / count


def numbers(folder, name, columns):
    return np.fromfile(os.path.join(folder, name), dtype="<f4").reshape(-1, columns)


def mitsuba(folder):
    """GGX on the same pairs, one thread."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(1)
    wi, wo = (mi.Vector3f(np.fromfile(os.path.join(folder, f"{w}.f32"), "<f4").reshape(3, -1)) for w in ("wi", "wo"))
    law = {"type": "roughdielectric", "distribution": "ggx", "alpha": 0.3, "int_ior": 1.49, "ext_ior": 1.0}
    bsdf = mi.load_dict(law)
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wi))
    si.wi = wi
    dr.eval(wo, si)
    found = []
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for _ in range(300):
            dr.kernel_history_clear()
            value = bsdf.eval(mi.BSDFContext(), si, wo)[0]
            dr.eval(value)
            dr.sync_thread()
            found.append(sum(k["execution_time"] for k in dr.kernel_history()))
    print(f"ggx batch f32,{1e6 * min(found) / dr.width(wi):.3f}")


def embree(folder):
    """First hits of the same rays with the same triangles, one thread."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    heights = numbers(folder, "map.f32", SIDE)
    y, x = np.mgrid[0:SIDE, 0:SIDE]
    points = np.stack([x, y, heights], axis=-1).reshape(-1, 3).astype(np.float32)
    a = (SIDE * y[:-1, :-1] + x[:-1, :-1]).reshape(-1)
    cells = np.concatenate([[a, a + 1, a + SIDE + 1], [a, a + SIDE, a + SIDE + 1]], axis=1).T.astype(np.int32)
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, points, np.ascontiguousarray(cells))
    for degrees in (5, 45, 75, 85):
        rays = numbers(folder, f"rays{degrees}.f32", 6)
        origins, directions = (np.ascontiguousarray(part) for part in (rays[:, :3], rays[:, 3:]))
        lengths = scene.run(origins, directions, query="DISTANCE")
        ours = numbers(folder, f"hits{degrees}.f32", 1)[:, 0]
        apart = np.abs((lengths - ours) * directions[:, 2])
        share = np.mean(apart < 1e-2)
        assert share > 0.9999, f"{degrees} deg: {1 - share:.1e} of the hits differ"
        ns = best(15, len(rays), lambda: scene.run(origins, directions, query="DISTANCE"))
        print(f"first hit {degrees},{ns:.1f}")


def scipy(_folder):
    """The same transform on two threads."""
    import scipy.fft

    k = np.arange(2048 * 2048)
    values = ((k % 17) + 1j * (k % 101)).reshape(2048, 2048)
    ns = best(15, 1, lambda: scipy.fft.fft2(values, workers=2))
    print(f"transform,{ns:.0f}")


def table(folder):
    """Shortest times of both sides and their ratios."""

    def shortest(name):
        found = {}
        with open(os.path.join(folder, name), encoding="utf-8") as lines:
            for line in lines:
                work, _, ns = line.strip().rpartition(",")
                if work and ns != "ns":
                    found[work] = min(found.get(work, float("inf")), float(ns))
        return found

    ours, theirs = shortest("ours.csv"), shortest("theirs.csv")
    print("| work | ns here | ns there | times as fast | peer |\n|---|---|---|---|---|")
    for work, ns in ours.items():
        peer = theirs.get(work)
        of = next((text for name, text in NAMES.items() if work.startswith(name)), "")
        cells = [f"{peer:.4g}", f"{peer / ns:.2f}", of] if peer else ["", "", ""]
        print("| " + " | ".join([work, f"{ns:.4g}", *cells]) + " |")


if __name__ == "__main__":
    if sys.argv[1] == "--table":
        table(sys.argv[2])
    else:
        {"mitsuba": mitsuba, "embree": embree, "scipy": scipy}[sys.argv[1]](sys.argv[2])
