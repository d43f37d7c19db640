"""Makes traced_map.npy and traced_scan.csv: a small rough map, and a plate with that face in a goniophotometer, ray by ray.

    python3 traced.py        (NumPy and Numba; some ten minutes)

Of the project nothing is used. The map is periodic, two triangles a cell with the diagonal from (x, y) to (x+1, y+1). Rays meet
it as often as they do; at every hit chance chooses between mirror and refraction (Fresnel, unpolarised). Below is a smooth
parallel face, so far away that light which comes back meets the rough face at a random place.
"""

import numpy as np
from numba import njit, prange

SIDE, PITCH_UM, RQ_UM, LENGTH_UM = 96, 1.0, 1.2, 6.0
N, APERTURE_DEG, STEP_DEG = 1.49, 2.0, 0.5
SIGMAS_DEG = (0.0, 20.0, 45.0, 65.0)
RAYS, BATCHES = 12_000_000, 64


def surface():
    """Gaussian heights, autocorrelation exp(-(r/L)^2), float32."""
    white = np.random.default_rng(20261129).standard_normal((SIDE, SIDE))
    f = np.fft.fftfreq(SIDE, PITCH_UM)
    f2 = f[:, None] ** 2 + f[None, :] ** 2
    h = np.fft.ifft2(np.fft.fft2(white) * np.exp(-0.5 * (np.pi * LENGTH_UM) ** 2 * f2)).real
    h -= h.mean()
    return (h * RQ_UM / h.std()).astype(np.float32)


@njit
def reflectance(cos_i, n):
    """Of a flat face; n the index beyond over that here."""
    c2 = 1.0 - (1.0 - cos_i * cos_i) / (n * n)
    if c2 <= 0.0:
        return 1.0
    c = np.sqrt(c2)
    s, p = (cos_i - n * c) / (cos_i + n * c), (n * cos_i - c) / (n * cos_i + c)
    return 0.5 * (s * s + p * p)


@njit
def meet(h, x, y, z, dx, dy, dz, low, high):
    """Distance to the next hit, and the slopes there; -1 where the ray leaves the slab of the heights."""
    side = h.shape[0]
    t = 0.0
    # into the slab
    if z > high:
        t = (high - z) / dz
    elif z < low:
        t = (low - z) / dz
    i, j = int(np.floor(x + t * dx)), int(np.floor(y + t * dy))
    eps = 1e-9
    for _ in range(1_000_000):
        # the way through cell (i, j)
        leave, si, sj = 1e30, 0, 0
        if dx > 0:
            leave, si = (i + 1 - x) / dx, 1
        elif dx < 0:
            leave, si = (i - x) / dx, -1
        if dy > 0 and (j + 1 - y) / dy < leave:
            leave, si, sj = (j + 1 - y) / dy, 0, 1
        elif dy < 0 and (j - y) / dy < leave:
            leave, si, sj = (j - y) / dy, 0, -1
        i0, j0 = i % side, j % side
        i1, j1 = (i0 + 1) % side, (j0 + 1) % side
        a, b, c, d = h[j0, i0], h[j0, i1], h[j1, i0], h[j1, i1]
        best, bp, bq = 1e30, 0.0, 0.0
        for k in range(2):
            # below the diagonal u >= v, above it v >= u
            p, q = (b - a, d - b) if k == 0 else (d - c, c - a)
            slope = dz - p * dx - q * dy
            if slope == 0.0:
                continue
            s = (a + p * (x - i) + q * (y - j) - z) / slope
            if s <= eps or s >= best:
                continue
            u, v = x + s * dx - i, y + s * dy - j
            inside = u >= v if k == 0 else v >= u
            if inside and -1e-12 <= u <= 1 + 1e-12 and -1e-12 <= v <= 1 + 1e-12:
                best, bp, bq = s, p, q
        if best < 1e29:
            return best, bp, bq
        if leave > 1e29:
            return -1.0, 0.0, 0.0
        at = z + leave * dz
        if (dz >= 0 and at > high) or (dz <= 0 and at < low):
            return -1.0, 0.0, 0.0
        i, j = i + si, j + sj
    return -1.0, 0.0, 0.0


@njit(parallel=True)
def scan(h, sigma, count, cones, half, seed):
    side, low, high = h.shape[0], h.min() - 1e-6, h.max() + 1e-6
    readings = np.zeros((BATCHES, cones.size))
    totals = np.zeros((BATCHES, 3))
    for batch in prange(BATCHES):
        np.random.seed(seed * 1000 + batch)
        for _ in range(count // BATCHES):
            x, y, z = np.random.random() * side, np.random.random() * side, high + 1.0
            dx, dy, dz = np.sin(sigma), 0.0, -np.cos(sigma)
            air, end = True, 2
            for _ in range(10_000):
                t, p, q = meet(h, x, y, z, dx, dy, dz, low, high)
                if t < 0.0:
                    if dz > 0.0:
                        end = 0 if air else 2
                        break
                    # down in the plate: the smooth face
                    if np.random.random() >= reflectance(-dz, 1.0 / N):
                        dx, dy = N * dx, N * dy
                        dz = -np.sqrt(max(0.0, 1.0 - dx * dx - dy * dy))
                        end = 1
                        break
                    dz = -dz
                    x, y, z = np.random.random() * side, np.random.random() * side, low - 1.0
                    continue
                x, y, z = x + t * dx, y + t * dy, z + t * dz
                inverse = 1.0 / np.sqrt(1.0 + p * p + q * q)
                mx, my, mz = -p * inverse, -q * inverse, inverse
                if not air:
                    mx, my, mz = -mx, -my, -mz
                cos = -(dx * mx + dy * my + dz * mz)
                if cos < 0.0:
                    end = 2
                    break
                n = N if air else 1.0 / N
                if np.random.random() < reflectance(cos, n):
                    dx, dy, dz = dx + 2 * cos * mx, dy + 2 * cos * my, dz + 2 * cos * mz
                else:
                    c = np.sqrt(1.0 - (1.0 - cos * cos) / (n * n))
                    f = cos / n - c
                    dx, dy, dz = dx / n + f * mx, dy / n + f * my, dz / n + f * mz
                    air = not air
                r = 1.0 / np.sqrt(dx * dx + dy * dy + dz * dz)
                dx, dy, dz = dx * r, dy * r, dz * r
                x, y = x % side, y % side
            totals[batch, end] += 1
            if end == 1 and abs(dy) <= np.sin(half):
                for k in range(cones.size):
                    if dx * np.sin(cones[k]) - dz * np.cos(cones[k]) >= np.cos(half):
                        readings[batch, k] += 1
    return readings.sum(axis=0), totals.sum(axis=0)


if __name__ == "__main__":
    heights = surface()
    np.save("traced_map.npy", heights)
    thetas = np.arange(-90.0, 90.0 + 0.5 * STEP_DEG, STEP_DEG)
    rows, notes = [], []
    count = RAYS // BATCHES * BATCHES
    for k, sigma_deg in enumerate(SIGMAS_DEG):
        got, totals = scan(
            heights.astype(np.float64) / PITCH_UM,
            np.radians(sigma_deg),
            count,
            np.radians(thetas),
            np.radians(0.5 * APERTURE_DEG),
            k + 1,
        )
        notes.append("%g: R %.6f T %.6f lost %.6f" % (sigma_deg, *(totals / count)))
        print(notes[-1], flush=True)
        rows += ["%g,%g,%.8g" % (sigma_deg, t, r / count) for t, r in zip(thetas, got)]
    with open("traced_scan.csv", "w") as out:
        out.write("# sample: traced_map.npy as the rough face of a plate; traced.py says how\n")
        out.write("# instrument: independent ray tracer, %d rays an incidence, all bounces and internal passes\n" % count)
        out.write("# geometry: transmission\n# ior: %g\n# rough_side: source\n" % N)
        out.write("# aperture_deg: %g\n# pixel_um: %g\n# map: traced_map.npy\n" % (APERTURE_DEG, PITCH_UM))
        out.write("# totals: %s\n" % "; ".join(notes))
        out.write("sigma_deg,theta_deg,reading\n" + "\n".join(rows) + "\n")
