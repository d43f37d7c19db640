"""Makes facets.csv, perturbation.csv and gratings.csv: three textbook limits of what a rough dielectric interface scatters.

    python3 interfaces.py        (NumPy)

Of the project nothing is used. Index 1.49, 0.55 um, unpolarised, in the plane of incidence, light that goes on forward; types: 0
from air to air, 1 from air into the medium, 2 in the medium, 3 from the medium to air; angles in the medium of their own.
"""

import numpy as np

N, WAVELENGTH_UM = 1.49, 0.55
K = 2 * np.pi / WAVELENGTH_UM
AIR = (0, 15, 30, 45, 60)


def fresnel(cos_i, n):
    """Reflectance; n the index beyond over that here."""
    c = np.sqrt(complex(1 - (1 - cos_i**2) / n**2))
    s, p = (cos_i - n * c) / (cos_i + n * c), (n * cos_i - c) / (n * cos_i + c)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


def leaves(wi, m, n, through):
    """Where light from wi goes at a facet of normal m that looks to it; by vectors, from Snell's law."""
    c = wi @ m
    if not through:
        return 2 * c * m - wi
    t = np.sqrt(1 - (1 - c * c) / n**2)
    return -wi / n + (c / n - t) * m


def facet(kind, i, o, slope=0.1):
    """f of single facets of Gaussian slopes, no shadowing, 1/sr. How a solid angle of normals becomes one of directions is
    found by turning the normal a little."""
    from_air, through = kind < 2, kind % 2 == 1
    n = N if from_air else 1 / N
    a, b = np.radians(i), np.radians(o)
    wi = np.array([-np.sin(a), 0, np.cos(a)])  # z towards the light
    wo = np.array([np.sin(b), 0, -np.cos(b) if through else np.cos(b)])
    h = wi + n * wo if through else wi + wo
    m = h / np.linalg.norm(h)
    if m[2] < 0:
        m = -m
    cos = wi @ m
    if cos <= 0 or (through and 1 - (1 - cos * cos) / n**2 <= 1e-8):
        return 0.0
    if np.abs(leaves(wi, m, n, through) - wo).max() > 1e-9:
        return 0.0
    step = 3e-7
    along, across = np.array([m[2], 0, -m[0]]), np.array([0.0, 1, 0])
    turned = lambda v: (lambda x: x / np.linalg.norm(x))(m + v)
    rate = lambda v: (leaves(wi, turned(step * v), n, through) - leaves(wi, turned(-step * v), n, through)) / (2 * step)
    jacobian = 1 / np.linalg.norm(np.cross(rate(along), rate(across)))
    r = fresnel(cos, n)
    density = np.exp(-((m[0] / m[2]) ** 2) / slope**2) / (np.pi * slope**2 * m[2] ** 4)
    return density * cos * (1 - r if through else r) * jacobian / (abs(wi[2]) * abs(wo[2]))


def perturbed(kind, i, o, sigma=0.01, length=2.0):
    """f of little roughness to first order, 1/sr: fields just above and below are continued to the surface and matched."""
    from_air, through = kind < 2, kind % 2 == 1
    n1, n2 = (1, N) if from_air else (N, 1)
    n_o = n2 if through else n1
    kx0, kx = K * n1 * np.sin(np.radians(i)), K * n_o * np.sin(np.radians(o))
    z = lambda n, k: np.sqrt(complex((n * K) ** 2 - k**2))
    q1, q2, p1, p2 = z(n1, kx0), z(n2, kx0), z(n1, kx), z(n2, kx)
    share = 0.0
    # along the grooves: E and its gradient are continuous
    t = 2 * q1 / (q1 + q2)
    a = -1j * (n1**2 - n2**2) * K**2 * t / (p1 + p2)
    share += 0.5 * abs(a) ** 2 * ((p2 if through else p1) / q1).real
    # across: H and its normal derivative over n^2 are continuous
    e1, e2 = 1 / n1**2, 1 / n2**2
    t = 2 * q1 * e1 / (q1 * e1 + q2 * e2)
    jump = 1j * q2 * t * (n1**2 - n2**2) / n2**2
    a, b = np.linalg.solve([[1, -1], [1j * p1 * e1, 1j * p2 * e2]], [jump, -t * kx0 * kx * (e1 - e2)])
    share += 0.5 * (abs(b) ** 2 * (p2 * e2 / (q1 * e1)).real if through else abs(a) ** 2 * (p1 / q1).real)
    spectrum = sigma**2 * length**2 / (4 * np.pi) * np.exp(-((kx - kx0) ** 2) * length**2 / 4)
    return share * spectrum * (n_o * K) ** 2


def grating(period, peak_to_valley):
    """Light along the normal from the air that a sine transmits, order by order: plane waves on both sides, matched on the
    surface by least squares [Rayleigh]. Right for slopes to 0.448; 0.47 still agrees with coupled waves to 1e-4."""
    most = 14 if period < 3 else 22 if period < 5 else 34
    orders = np.arange(-most, most + 1)
    x = np.arange(8 * most) * period / (8 * most)
    h = 0.5 * peak_to_valley * np.sin(2 * np.pi * x / period)
    slope = np.pi * peak_to_valley / period * np.cos(2 * np.pi * x / period)
    kx = 2 * np.pi * orders / period
    p1, p2 = (np.sqrt((n * K) ** 2 - kx.astype(complex) ** 2) for n in (1, N))
    up = np.exp(1j * (kx * x[:, None] + p1 * h[:, None]))
    down = np.exp(1j * (kx * x[:, None] - p2 * h[:, None]))
    light = np.exp(-1j * K * h)
    total = 0
    for e2 in (1.0, 1 / N**2):
        normal_up = 1j * (p1 - slope[:, None] * kx) * up
        normal_down = 1j * (-p2 - slope[:, None] * kx) * down
        matrix = np.block([[up, -down], [normal_up / K, -e2 * normal_down / K]])
        scale = np.abs(matrix).max(axis=0)
        right = np.concatenate([-light, 1j * light])
        found = np.linalg.lstsq(matrix / scale, right, rcond=None)[0] / scale
        b = found[orders.size :]
        total = total + 0.5 * np.abs(b) ** 2 * (e2 * p2.real / K)
    return orders, total


if __name__ == "__main__":
    with open("facets.csv", "w") as out:
        out.write("# single facets, rms slope 0.1 / sqrt(2) along each axis, without shadowing; theta_o + 1e-3 deg; interfaces.py says how\n")
        out.write("type,theta_i_deg,theta_o_deg,f_per_sr\n")
        for kind in range(4):
            for i in AIR if kind < 2 else AIR[:3]:
                for o in range(86):
                    out.write(f"{kind},{i},{o},{facet(kind, i, o + 1e-3):.8e}\n")
    with open("perturbation.csv", "w") as out:
        out.write("# first order in the heights: 0.01 um rms, autocorrelation exp(-(r / 2 um)^2); interfaces.py says how\n")
        out.write("type,theta_i_deg,theta_o_deg,f_per_sr\n")
        for kind in range(4):
            for i in AIR[:3]:
                for o in range(86):
                    out.write(f"{kind},{i},{o},{perturbed(kind, i, o):.8e}\n")
    with open("gratings.csv", "w") as out:
        out.write("# transmitted share of each order of sines, light along the normal from the air; interfaces.py says how\n")
        out.write("period_um,peak_to_valley_um,order,share\n")
        for period, pv in ((2, 0.3), (4, 0.5), (8, 0.5), (8, 1)):
            orders, shares = grating(period, pv)
            for m, share in zip(orders, shares):
                if abs(m) <= (5 if period == 2 else 8):
                    out.write(f"{period},{pv},{m},{share:.6e}\n")
