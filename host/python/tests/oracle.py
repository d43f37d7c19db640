"""GGX on a dielectric in numpy, written down from Walter 2007 (eqs 8, 13-14, 16, 20-23, 33-34), as an oracle."""

import numpy as np


def directions(count, seed):
    """Unit vectors all over the sphere, (count, 3)."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(-1, 1, count)
    phi = rng.uniform(0, 2 * np.pi, count)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def dot(a, b):
    return np.sum(a * b, axis=-1)


def fresnel(c, n):
    """Unpolarised reflectance for the cosine c at the facet, n the far index over the near one."""
    g2 = n * n - 1 + c * c
    g = np.sqrt(np.maximum(g2, 0))
    s = ((g - c) / (g + c)) ** 2
    p = ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2
    return np.where(g2 > 0, 0.5 * s * (1 + p), 1.0)


def distribution(alpha, mz):
    tan2 = (1 - mz * mz) / (mz * mz)
    return alpha**2 / (np.pi * mz**4 * (alpha**2 + tan2) ** 2)


def masking(alpha, w):
    tan2 = (w[..., 0] ** 2 + w[..., 1] ** 2) / w[..., 2] ** 2
    return 2 / (1 + np.sqrt(1 + alpha**2 * tan2))


def eval_ggx(alpha, ior, wi, wo):
    """f in 1/sr, flux transport: Walter's f_s times (n_i / n_o)^2 in transmission."""
    ci, co = wi[..., 2], wo[..., 2]
    n_i = np.where(ci > 0, 1.0, ior)
    n_o = np.where(co > 0, 1.0, ior)
    far = np.where(ci > 0, ior, 1.0) / n_i
    mirrored = ci * co > 0
    h = n_i[..., None] * wi + n_o[..., None] * wo
    m = h / np.linalg.norm(h, axis=-1, keepdims=True)
    m = np.where(m[..., 2:] < 0, -m, m)
    im, om, mz = dot(wi, m), dot(wo, m), m[..., 2]
    seen = (im * ci > 0) & (om * co > 0)
    share = fresnel(np.abs(im), far)
    d, g = distribution(alpha, mz), masking(alpha, wi) * masking(alpha, wo)
    reflected = share * d * g / (4 * np.abs(ci * co))
    # |wi.m| |wo.m| / (|ci| |co|) n_o^2 (1 - F) G D / (n_i wi.m + n_o wo.m)^2 is for radiance
    below = (n_i * im + n_o * om) ** 2
    radiance = np.abs(im * om) / np.abs(ci * co) * n_o**2 * (1 - share) * d * g / below
    return np.where(seen, np.where(mirrored, reflected, radiance), 0.0)
