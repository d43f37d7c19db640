"""Makes kirchhoff_gaussian.csv: what Gaussian surfaces scatter, scalar Kirchhoff kernel, by quadrature with SciPy.

    python3 kirchhoff_gaussian.py > kirchhoff_gaussian.csv

Of the project nothing is used. With g = (v_z sigma)^2, v = k (n_o o - n_i i):

    coherent = exp(-g) in the specular direction
    D = 1/(2 pi) int_0^inf [exp(-g (1 - exp(-(r/L)^2))) - exp(-g)] J_0(v_xy r) r dr      (um^2)
"""

import numpy as np
from scipy.special import j0

WAVELENGTH_UM, N = 0.55, 1.49
K = 2 * np.pi / WAVELENGTH_UM
SURFACES = [(0.01, 2), (0.05, 5), (0.1, 5), (0.25, 5), (0.5, 10), (1.0, 15), (2.5, 30)]
GEOMETRIES = [("refl_air", 1, 1), ("trans_air_to_n", 1, N), ("trans_n_to_air", N, 1)]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def density(g, v, length):
    # beyond the end the bracket is below 1e-20 of exp(-g)'s scale
    end = length * np.sqrt(np.log(max(g, 1.0)) + 46.0)
    panels = 2000
    edges = np.linspace(0.0, end, panels + 1)
    half = 0.5 * (edges[1:] - edges[:-1])[:, None]
    r = (0.5 * (edges[1:] + edges[:-1])[:, None] + half * NODES).ravel()
    w = (half * WEIGHTS).ravel()
    c = np.exp(-((r / length) ** 2))
    bracket = np.exp(-g * (1.0 - c)) * -np.expm1(-g * c)
    return np.sum(w * r * bracket * j0(v * r)) / (2 * np.pi)


print("# scalar Kirchhoff kernel of Gaussian surfaces, wavelength 0.55 um, index 1.49; kirchhoff_gaussian.py says how")
print("geometry,sigma_um,L_um,thetai_deg,thetao_deg,coherent,D_um2")
for sigma, length in SURFACES:
    for name, n_i, n_o in GEOMETRIES:
        for incidence in (0, 15, 30):
            sin_i = n_i * np.sin(np.radians(incidence))
            cos_i = n_i * np.cos(np.radians(incidence))
            sign = 1 if name == "refl_air" else -1
            v_z = lambda cos_o: K * abs(n_o * cos_o + sign * cos_i)
            specular = np.arcsin(sin_i / n_o)
            coherent = np.exp(-((v_z(np.cos(specular)) * sigma) ** 2))
            for off in (0, 1, 2, 5, 10, 20, 30):
                theta = float(f"{np.degrees(specular) + off:.6f}")
                sin_o, cos_o = np.sin(np.radians(theta)), np.cos(np.radians(theta))
                g = (v_z(cos_o) * sigma) ** 2
                d = density(g, K * abs(n_o * sin_o - sin_i), length)
                # what cancels to less than this is rounding
                text = f"{d:.8e}" if d > 1e-9 else "0"
                print(f"{name},{sigma:g},{length},{incidence},{theta:.6f},{coherent:.8e},{text}")
