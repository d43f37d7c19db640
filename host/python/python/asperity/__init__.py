"""Evaluate, sample and fit the BSDF of rough optical surfaces.

Directions are unit vectors that point away from the surface; +z is the mean normal and points into the air.
``eval`` is the BSDF f in 1/sr without cosine, ``ars`` is f |cos theta_o|, ``pdf`` the density of ``sample``.
Flux is transported, not radiance: transmission carries no eta^2.
"""

from ._native import (
    Ggx,
    HeightMap,
    Model,
    Normals,
    Scan,
    Table,
    __version__,
    check,
    compare,
    fit,
    read_map,
    read_scan,
    scan,
)

__all__ = [
    "Ggx",
    "HeightMap",
    "Model",
    "Normals",
    "Scan",
    "Table",
    "__version__",
    "check",
    "compare",
    "fit",
    "read_map",
    "read_scan",
    "scan",
]
